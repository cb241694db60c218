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

// The request is a valid upgrade; a WebSocket takes over the connection.
struct UpgradeToWebSocket {};
using Outcome = std::variant<Answer, UpgradeToWebSocket>;

class RequestHandler {
 public:
  virtual ~RequestHandler() = default;

  // Does not throw for any client input. Request and context must outlive the coroutine.
  [[nodiscard]] virtual asio::awaitable<Outcome> answer(const HttpRequest& request,
                                                        RequestContext& context) = 0;
  // Returns whether the target is a health probe or the metrics, which are answered also above the
  // limits of connections.
  [[nodiscard]] virtual bool is_probe(std::string_view target) const = 0;
  // Returns a request's target as it may be logged.
  [[nodiscard]] virtual std::string loggable(std::string_view target) const = 0;
};

}  // namespace multitetra
