#include "server/gateway/http_door.hpp"

#include <algorithm>
#include <utility>
#include <vector>

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

std::string HttpDoor::url() const {
  return http_url(listener_.endpoint(), /*is_secure=*/house_.keeper.tls() != nullptr);
}

void HttpDoor::open() {
  listener_.open(
      [this](tcp::socket socket, const Peer& peer) { welcome(std::move(socket), peer); });
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

void HttpDoor::welcome(tcp::socket socket, const Peer& peer) {
  Doorkeeper::Admitted admitted = house_.keeper.admit("http", peer.address, peer.name);
  if (!admitted.guest) return;
  const GuestPtr guest = admitted.guest;
  const std::uint64_t id = guest->facts().connection;
  auto stream = std::make_unique<StreamSocket>(std::move(socket), house_.keeper.tls());
  const auto connection = std::make_shared<HttpConnection>(
      std::move(stream), guest, std::move(admitted.refusal), service_, options_);
  visitors_.emplace(id, connection);
  try {
    connection->start(
        [this, guest](std::unique_ptr<StreamSocket> taken, HttpRequest request) {
          upgrade(guest, std::move(taken), std::move(request));
        },
        [this, id] { leave(id); });
  } catch (...) {
    visitors_.erase(id);
    throw;
  }
}

void HttpDoor::upgrade(const GuestPtr& guest, std::unique_ptr<StreamSocket> stream,
                       HttpRequest request) {
  guest->changes_to("websocket");
  const std::uint64_t id = guest->facts().connection;
  const auto connection = std::make_shared<WebSocketConnection>(
      std::move(stream), std::move(request), guest, service_.new_dialogue(guest), options_);
  visitors_[id] = connection;
  connection->start([this, id] { leave(id); });
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

std::string http_url(const Endpoint& endpoint, bool is_secure) {
  std::string url = to_string(endpoint);
  url.replace(0, url.find(':'), is_secure ? "https" : "http");
  return url;
}

}  // namespace multitetra
