#include "server/gateway/http_door.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>

#include "server/gateway/http_connection.hpp"
#include "server/gateway/websocket_connection.hpp"

namespace multitetra {
namespace {

// Often enough that no limit is exceeded by more than a tenth or so, and seldom enough to cost
// nothing.
std::chrono::milliseconds time_between_looks(const HttpOptions& options) {
  const auto shortest = std::min({options.handshake_timeout, options.keep_alive_timeout,
                                  options.write_timeout, options.linger});
  return std::clamp<std::chrono::milliseconds>(shortest / 8, std::chrono::milliseconds(5),
                                               std::chrono::milliseconds(250));
}

}  // namespace

HttpDoor::HttpDoor(const House& house, HttpOptions options)
    : house_(house),
      options_(std::move(options)),
      service_(house_, options_),
      listener_(house_.io, options_.listen),
      timer_(house_.io) {}

void HttpDoor::open() {
  listener_.open(
      [this](tcp::socket socket, const std::string& peer) { welcome(std::move(socket), peer); });
  asio::co_spawn(
      house_.io, [this] { return keep_time(); }, asio::detached);
}

void HttpDoor::close(const Error& why) {
  is_closed_ = true;
  listener_.close();
  timer_.cancel();
  // Whoever ends at once leaves the map while it is walked.
  std::vector<std::shared_ptr<Visitor>> all;
  for (const auto& [id, visitor] : visitors_) all.push_back(visitor);
  for (const auto& visitor : all) visitor->end(why);
}

void HttpDoor::welcome(tcp::socket socket, const std::string& peer) {
  if (visitors_.size() >= options_.max_connections) {
    spdlog::warn("{}: refused, there are {} connections", peer, visitors_.size());
    return;
  }
  const std::uint64_t id = next_id_++;
  auto stream = std::make_unique<StreamSocket>(std::move(socket), next_context(options_.tls));
  const auto connection =
      std::make_shared<HttpConnection>(std::move(stream), peer, service_, options_);
  visitors_.emplace(id, connection);
  try {
    connection->start(
        [this, id, peer](std::unique_ptr<StreamSocket> taken, HttpRequest request) {
          upgrade(id, peer, std::move(taken), std::move(request));
        },
        [this, id] { leave(id); });
  } catch (...) {
    visitors_.erase(id);
    throw;
  }
}

void HttpDoor::upgrade(std::uint64_t id, const std::string& peer,
                       std::unique_ptr<StreamSocket> stream, HttpRequest request) {
  spdlog::info("{}: WebSocket connected", peer);
  const auto connection = std::make_shared<WebSocketConnection>(
      std::move(stream), std::move(request), service_.new_dialogue(peer), options_);
  visitors_[id] = connection;
  connection->start([this, id, peer] {
    leave(id);
    spdlog::info("{}: WebSocket disconnected", peer);
  });
  if (is_closed_) connection->end({ErrorCode::kUnavailable, "The server stops."});
}

void HttpDoor::leave(std::uint64_t id) {
  visitors_.erase(id);
  if (is_closed_) timer_.cancel();
}

asio::awaitable<void> HttpDoor::keep_time() {
  const auto pause = time_between_looks(options_);
  while (!is_closed_ || !visitors_.empty()) {
    timer_.expires_after(pause);
    boost::system::error_code ignored;
    co_await timer_.async_wait(use_error(ignored));
    const Clock::time_point now = Clock::now();
    // Nobody leaves the map here: ends are told by the coroutines, later.
    for (const auto& [id, visitor] : visitors_) visitor->keep_time(now);
  }
}

Result<Endpoint> parse_http_endpoint(std::string_view text) {
  constexpr std::string_view kScheme = "http://";
  const std::string_view rest = text.starts_with(kScheme) ? text.substr(kScheme.size()) : text;
  auto endpoint = parse_endpoint(rest);
  if (!endpoint || rest.ends_with(']') || rest.find(':') == std::string_view::npos) {
    return fail(ErrorCode::kInvalidArgument,
                "\"" + std::string(text) +
                    "\" is no address for HTTP; write HOST:PORT, for example " +
                    http_url(HttpOptions{}.listen) + ".");
  }
  return endpoint;
}

std::string http_url(const Endpoint& endpoint) {
  std::string url = to_string(endpoint);
  url.replace(0, url.find(':'), "http");
  return url;
}

}  // namespace multitetra
