// The interface through which connections call the routes.
#pragma once

#include <string>
#include <string_view>

#include "common/net/net.hpp"
#include "server/http/http_request.hpp"
#include "server/http/http_response.hpp"
#include "server/http/request_context.hpp"

namespace multitetra {

class RequestHandler {
 public:
  virtual ~RequestHandler() = default;

  // Does not throw for any client input. Request and context must outlive the coroutine. After an
  // answer of status 101 a WebSocket takes over the connection.
  [[nodiscard]] virtual asio::awaitable<HttpResponse> answer(const HttpRequest& request,
                                                             RequestContext& context) = 0;
  // Returns whether the target is a health probe or the metrics, which are answered also above the
  // limits of connections.
  [[nodiscard]] virtual bool is_probe(std::string_view target) const = 0;
  // Returns a request's target as it may be logged.
  [[nodiscard]] virtual std::string loggable(std::string_view target) const = 0;
};

}  // namespace multitetra
