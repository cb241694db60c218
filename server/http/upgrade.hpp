// Checks whether a request may become a WebSocket conversation. Pure.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/http/http_request.hpp"
#include "server/http/http_response.hpp"

namespace multitetra {

// Returns an answer of status 101 if the upgrade is allowed, else the refusal: it must request the
// subprotocol multitetra.v1, and come from a page of this listener, from an allowed origin, or from
// no page.
[[nodiscard]] HttpResponse upgrade_answer(const HttpRequest& request,
                                          const std::vector<std::string>& allowed_origins,
                                          std::string_view request_id);

}  // namespace multitetra
