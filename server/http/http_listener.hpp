// The listener for HTTP and WebSockets on one port.
#pragma once

#include <cstdint>
#include <map>
#include <memory>

#include "server/http/http_options.hpp"
#include "server/http/http_service.hpp"
#include "server/http/http_session.hpp"
#include "server/transport/acceptor.hpp"
#include "server/transport/listener.hpp"

namespace multitetra {

class HttpListener : public Listener {
 public:
  // Binds and listens. Throws std::runtime_error that names the address when that fails.
  HttpListener(const ServerContext& server, HttpOptions options);

  [[nodiscard]] Endpoint endpoint() const override { return acceptor_.endpoint(); }
  [[nodiscard]] std::string url() const override;
  void open() override;
  void close(const Error& why) override;

 private:
  void welcome(tcp::socket socket, const Peer& peer);
  void upgrade(const ClientContextPtr& client, std::unique_ptr<StreamSocket> stream,
               HttpRequest request);
  void leave(std::uint64_t id);
  // Until the listener is closed and everybody has gone.
  asio::awaitable<void> keep_time();

  ServerContext server_;
  HttpOptions options_;
  HttpService service_;
  Acceptor acceptor_;
  asio::steady_timer timer_;
  bool is_closed_ = false;
  std::map<std::uint64_t, std::shared_ptr<HttpSession>> sessions_;
};

// "HOST:PORT", also behind "http://". kInvalidArgument, with the text and an example, otherwise.
[[nodiscard]] Result<Endpoint> parse_http_endpoint(std::string_view text);
// "http://HOST:PORT", or "https://HOST:PORT".
[[nodiscard]] std::string http_url(const Endpoint& endpoint, bool is_secure = false);

}  // namespace multitetra
