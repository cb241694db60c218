#include "server/gateway/http_service.hpp"

#include <array>
#include <cstdio>
#include <random>

#include "common/websocket.hpp"
#include "server/gateway/origin.hpp"

namespace multitetra {
namespace {

bool asks_for_subprotocol(const HttpRequest& request) {
  const auto offered = request.equal_range(http::field::sec_websocket_protocol);
  for (auto line = offered.first; line != offered.second; ++line) {
    http::token_list names(line->value());
    if (names.exists(beast::string_view(kSubprotocol.data(), kSubprotocol.size()))) return true;
  }
  return false;
}

}  // namespace

HttpService::HttpService(const House& house, const HttpOptions& options)
    : house_(house),
      options_(options),
      next_request_((std::uint64_t{std::random_device{}()} << 32) | 1) {}

std::string HttpService::new_request_id() {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx",
                static_cast<unsigned long long>(next_request_++));
  return text.data();
}

Outcome HttpService::upgrade(const HttpRequest& request, std::string_view request_id) const {
  const auto refuse = [&](int status, ErrorCode code, std::string text) {
    return error_answer(status, {code, std::move(text)}, request_id);
  };
  if (!websocket::is_upgrade(request)) {
    Answer answer = refuse(426, ErrorCode::kUnexpectedMessage,
                           "This is the door for WebSockets (RFC 6455) of " +
                               std::string(kSubprotocol) + "; ask for an upgrade.");
    add_field(answer, "Upgrade", "websocket");
    return answer;
  }
  if (!asks_for_subprotocol(request)) {
    return refuse(400, ErrorCode::kUnsupportedVersion,
                  "A WebSocket here speaks the subprotocol " + std::string(kSubprotocol) +
                      "; name it in Sec-WebSocket-Protocol.");
  }
  if (!is_allowed_origin(field(request, http::field::origin), field(request, http::field::host),
                         options_.allowed_origins)) {
    return refuse(403, ErrorCode::kInvalidArgument,
                  "Pages of another origin may not open a WebSocket here; the server names those "
                  "that may with --allow-origin.");
  }
  return UpgradeToWebSocket{};
}

asio::awaitable<Outcome> HttpService::answer(const HttpRequest& request,
                                             std::string_view request_id) {
  const std::string_view target = view_of(request.target());
  const std::string_view path = target.substr(0, target.find('?'));
  if (path == kStreamPath) co_return upgrade(request, request_id);
  if (path == "/livez") co_return json_answer(200, "{\"status\":\"ok\"}\n");
  co_return error_answer(
      404, {ErrorCode::kInvalidArgument, "There is nothing at \"" + std::string(path) + "\"."},
      request_id);
}

}  // namespace multitetra
