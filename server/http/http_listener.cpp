#include "server/http/http_listener.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "server/http/http_connection.hpp"
#include "server/http/websocket_connection.hpp"

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

HttpListener::HttpListener(const ServerContext& server, HttpOptions options)
    : server_(server),
      options_(std::move(options)),
      service_(server_, options_),
      acceptor_(server_.io, options_.listen),
      timer_(server_.io) {}

std::string HttpListener::url() const {
  return http_url(acceptor_.endpoint(), /*is_secure=*/server_.admission.tls() != nullptr);
}

void HttpListener::open() {
  acceptor_.open(
      [this](tcp::socket socket, const Peer& peer) { welcome(std::move(socket), peer); });
  asio::co_spawn(
      server_.io, [this] { return keep_time(); }, asio::detached);
}

void HttpListener::close(const Error& why) {
  is_closed_ = true;
  acceptor_.close();
  timer_.cancel();
  // Whoever ends at once leaves the map while it is walked.
  std::vector<std::shared_ptr<HttpSession>> all;
  for (const auto& [id, session] : sessions_) all.push_back(session);
  for (const auto& session : all) session->end(why);
}

void HttpListener::welcome(tcp::socket socket, const Peer& peer) {
  AdmissionControl::Admitted admitted = server_.admission.admit("http", peer.address, peer.name);
  if (!admitted.client) return;
  const ClientContextPtr client = admitted.client;
  const std::uint64_t id = client->facts().connection;
  auto stream = std::make_unique<StreamSocket>(std::move(socket), server_.admission.tls());
  const auto connection = std::make_shared<HttpConnection>(
      std::move(stream), client, std::move(admitted.refusal), service_, options_);
  sessions_.emplace(id, connection);
  try {
    connection->start(
        [this, client](std::unique_ptr<StreamSocket> taken, HttpRequest request) {
          upgrade(client, std::move(taken), std::move(request));
        },
        [this, id] { leave(id); });
  } catch (...) {
    sessions_.erase(id);
    throw;
  }
}

void HttpListener::upgrade(const ClientContextPtr& client, std::unique_ptr<StreamSocket> stream,
                           HttpRequest request) {
  client->changes_to("websocket");
  const std::uint64_t id = client->facts().connection;
  const auto connection = std::make_shared<WebSocketConnection>(
      std::move(stream), std::move(request), client, service_.new_session(client), options_);
  sessions_[id] = connection;
  connection->start([this, id] { leave(id); });
  if (is_closed_) connection->end({ErrorCode::kUnavailable, "The server stops."});
}

void HttpListener::leave(std::uint64_t id) {
  sessions_.erase(id);
  if (is_closed_) timer_.cancel();
}

asio::awaitable<void> HttpListener::keep_time() {
  const auto pause = time_between_looks(options_);
  while (!is_closed_ || !sessions_.empty()) {
    timer_.expires_after(pause);
    boost::system::error_code ignored;
    co_await timer_.async_wait(use_error(ignored));
    const Clock::time_point now = Clock::now();
    // Nobody leaves the map here: ends are told by the coroutines, later.
    for (const auto& [id, session] : sessions_) session->keep_time(now);
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
