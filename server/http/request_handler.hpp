// The interface through which connections call the routes.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "common/net/net.hpp"
#include "server/http/answer.hpp"
#include "server/http/http_request.hpp"
#include "server/http/request_context.hpp"

namespace multitetra {

// The request was a good one for a WebSocket, which takes over the connection.
struct UpgradeToWebSocket {};
using Outcome = std::variant<Answer, UpgradeToWebSocket>;

class RequestHandler {
 public:
  virtual ~RequestHandler() = default;

  // Never throws for what a client sent. Request and context live until it is answered.
  [[nodiscard]] virtual asio::awaitable<Outcome> answer(const HttpRequest& request,
                                                        RequestContext& context) = 0;
  // A request's target as the log may have it.
  [[nodiscard]] virtual std::string loggable(std::string_view target) const = 0;
};

}  // namespace multitetra
