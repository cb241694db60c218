#include "server/http/upgrade.hpp"

#include <utility>

#include <boost/beast/http/rfc7230.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include "common/net/endpoint.hpp"
#include "server/http/origin.hpp"

namespace multitetra {
namespace {

bool asks_for_subprotocol(const HttpRequest& request) {
  const auto offered = request.equal_range(http::field::sec_websocket_protocol);
  for (auto line = offered.first; line != offered.second; ++line) {
    http::token_list names(line->value());
    if (names.exists(boost::beast::string_view(kSubprotocol.data(), kSubprotocol.size())))
      return true;
  }
  return false;
}

}  // namespace

HttpResponse upgrade_answer(const HttpRequest& request,
                            const std::vector<std::string>& allowed_origins,
                            std::string_view request_id) {
  const auto refuse = [&](int status, ErrorCode code, std::string text) {
    return error_answer(status, {code, std::move(text)}, request_id);
  };
  if (!boost::beast::websocket::is_upgrade(request)) {
    HttpResponse response = refuse(426, ErrorCode::kUnexpectedMessage,
                                   "This is the listener for WebSockets (RFC 6455) of " +
                                       std::string(kSubprotocol) + "; send an upgrade request.");
    add_field(response, "Upgrade", "websocket");
    return response;
  }
  if (!asks_for_subprotocol(request)) {
    return refuse(400, ErrorCode::kUnsupportedVersion,
                  "WebSockets of this server use the subprotocol " + std::string(kSubprotocol) +
                      "; set it in Sec-WebSocket-Protocol.");
  }
  if (!is_allowed_origin(field(request, http::field::origin), field(request, http::field::host),
                         allowed_origins)) {
    return refuse(403, ErrorCode::kInvalidArgument,
                  "Pages of other origins may not open a WebSocket to this server, except those "
                  "that it allows with --allow-origin.");
  }
  return {.status = 101};
}

}  // namespace multitetra
