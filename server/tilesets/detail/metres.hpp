// How long a dataset's unit of length is.
#pragma once

#include <optional>
#include <string_view>

namespace multitetra {

// Of a unit's name as volume files have it, "mm" or "micrometer" for example; none where it is no
// length that is known here.
[[nodiscard]] std::optional<double> metres_of(std::string_view unit);

}  // namespace multitetra
