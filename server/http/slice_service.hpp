// The samples themselves over HTTP: slices as pictures or numbers, and what the field is at a
// place.
#pragma once

#include <string>

#include "server/http/answer.hpp"
#include "server/http/one_shot_session.hpp"
#include "server/http/request_context.hpp"
#include "server/http/slice_query.hpp"
#include "server/http/target.hpp"
#include "server/stream/workers.hpp"

namespace multitetra {

class SliceService {
 public:
  // `one_shot` is greeted. Makes nothing for HEAD, nor where the client has it already.
  [[nodiscard]] asio::awaitable<Answer> slice(const std::string& dataset, const Target& target,
                                              const HttpRequest& request, OneShotSession& one_shot,
                                              RequestContext& context);
  // {"places":[{"world","index","value","gradient"}]}; the latter two are null where there is no
  // field.
  [[nodiscard]] asio::awaitable<Answer> value(const std::string& dataset, const Target& target,
                                              OneShotSession& one_shot, RequestContext& context);

 private:
  Workers drawing_{1};  // Makes pictures of values.
};

}  // namespace multitetra
