// Whether a request may become a WebSocket of the conversation. Pure.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/answer.hpp"
#include "server/http/http_request.hpp"

namespace multitetra {

// The reason to refuse an upgrade; nullopt if it is allowed. It must request the subprotocol
// multitetra.v1, and come from a page of this listener or of an allowed origin, or from no page.
[[nodiscard]] std::optional<Answer> upgrade_error(const HttpRequest& request,
                                                  const std::vector<std::string>& allowed_origins,
                                                  std::string_view request_id);

}  // namespace multitetra
