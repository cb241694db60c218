// The description of the HTTP interface, /v1/openapi.json.
//
// openapi.json has its prose. What the tables of parameters and of a dataset's fields say is added:
// a key that begins with $ stands for
//
//   {"$parameters": "slice"}   in a list of parameters: those of the table
//   {"$dataset": true}         the schema of a dataset
//   {"$error": "text"}         a response with an Error
//   {"$part_of": "200"}        a response with the requested range of another one
//   "$shared": [304, 404]      responses that resources have in common
#pragma once

#include <string>

namespace multitetra {

[[nodiscard]] const std::string& api_description();

}  // namespace multitetra
