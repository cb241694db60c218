// The door for HTTP and WebSockets on one port.
#pragma once

#include <cstdint>
#include <map>
#include <memory>

#include "server/gateway/http_options.hpp"
#include "server/gateway/http_service.hpp"
#include "server/gateway/visitor.hpp"
#include "server/service/door.hpp"
#include "server/service/listener.hpp"

namespace multitetra {

class HttpDoor : public Door {
 public:
  // Binds and listens. Throws std::runtime_error that names the address when that fails.
  HttpDoor(const House& house, HttpOptions options);

  [[nodiscard]] Endpoint endpoint() const override { return listener_.endpoint(); }
  [[nodiscard]] std::string url() const override;
  void open() override;
  void close(const Error& why) override;

 private:
  void welcome(tcp::socket socket, const Peer& peer);
  void upgrade(const GuestPtr& guest, std::unique_ptr<StreamSocket> stream, HttpRequest request);
  void leave(std::uint64_t id);
  // Until the door is closed and everybody has gone.
  asio::awaitable<void> keep_time();

  House house_;
  HttpOptions options_;
  HttpService service_;
  Listener listener_;
  asio::steady_timer timer_;
  bool is_closed_ = false;
  std::map<std::uint64_t, std::shared_ptr<Visitor>> visitors_;
};

// "HOST:PORT", also behind "http://". kInvalidArgument, with the text and an example, otherwise.
[[nodiscard]] Result<Endpoint> parse_http_endpoint(std::string_view text);
// "http://HOST:PORT", or "https://HOST:PORT".
[[nodiscard]] std::string http_url(const Endpoint& endpoint, bool is_secure = false);

}  // namespace multitetra
