// Checks whether a request may become a WebSocket conversation. Pure.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/answer.hpp"
#include "server/http/http_request.hpp"

namespace multitetra {

// Returns the refusal of an upgrade, or nullopt if it is allowed: it must request the subprotocol
// multitetra.v1, and come from a page of this listener, from an allowed origin, or from no page.
[[nodiscard]] std::optional<Answer> upgrade_error(const HttpRequest& request,
                                                  const std::vector<std::string>& allowed_origins,
                                                  std::string_view request_id);

}  // namespace multitetra
