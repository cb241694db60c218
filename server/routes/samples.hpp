// The samples themselves over HTTP: slices as pictures or numbers, and what the field is at a
// place.
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
  // Makes nothing for HEAD, nor where the client has it already.
  [[nodiscard]] asio::awaitable<Answer> slice(const std::string& dataset, const Target& target,
                                              const HttpRequest& request, RequestContext& context);
  // {"places":[{"world","index","value","gradient"}]}; the latter two are null where there is no
  // field.
  [[nodiscard]] asio::awaitable<Answer> value(const std::string& dataset, const Target& target,
                                              RequestContext& context);

 private:
  Workers drawing_{1};  // Makes pictures of values.
};

}  // namespace multitetra
