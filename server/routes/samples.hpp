// The samples over HTTP: slices as pictures or numbers, and the field's value at given places.
#pragma once

#include <string>

#include "server/http/answer.hpp"
#include "server/http/request_context.hpp"
#include "server/http/target.hpp"
#include "server/routes/detail/slice_query.hpp"
#include "server/service/workers.hpp"

namespace multitetra {

class SamplesRoute {
 public:
  // Makes nothing for HEAD, nor if the client's copy is current.
  [[nodiscard]] asio::awaitable<Answer> slice(const std::string& dataset, const Target& target,
                                              const HttpRequest& request, RequestContext& context);
  // Returns {"places":[{"world","index","value","gradient"}]}; value and gradient are null in the
  // void.
  [[nodiscard]] asio::awaitable<Answer> value(const std::string& dataset, const Target& target,
                                              RequestContext& context);

 private:
  Workers drawing_{1};  // Colors slices.
};

}  // namespace multitetra
