#include "server/relay/relay_server.hpp"

#include <csignal>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/gateway/http_door.hpp"
#include "server/relay/relay_dialogue.hpp"

namespace multitetra {

class RelayServer::Running {
 public:
  explicit Running(RelayServerOptions options)
      : options_(std::move(options)),
        keeper_(options_.keeper),
        io_(/*concurrency_hint=*/1),
        relay_(std::make_shared<Relay>(io_.get_executor(), options_.relay)),
        signals_(io_) {
    const House house = {
        .io = io_, .keeper = keeper_, .new_dialogue = [this](GuestPtr guest) -> DialoguePtr {
          return std::make_shared<RelayDialogue>(io_.get_executor(), relay_, options_.session,
                                                 std::move(guest));
        }};
    if (options_.tcp) tcp_ = std::make_unique<TcpDoor>(house, *options_.tcp);
    if (options_.http) {
      HttpOptions http = *options_.http;
      http.hooks.is_ready = [this] { return relay_->is_ready(); };
      http.hooks.find_tile = [this](const ContentDigest& digest) {
        return relay_->tiles().find_plain(digest);
      };
      http_ = std::make_unique<HttpDoor>(house, std::move(http));
    }
  }

  [[nodiscard]] Endpoint http() const { return http_->endpoint(); }
  [[nodiscard]] Endpoint tcp() const { return tcp_->endpoint(); }

  void run() {
    if (options_.stop_on_signals) watch_signals();
    if (tcp_) tcp_->open();
    if (http_) http_->open();
    asio::co_spawn(
        io_, [relay = relay_] { return relay->look_after_upstreams(); }, asio::detached);
    io_.run();
  }

  void stop() {
    asio::post(io_, [this] {
      if (std::exchange(is_stopping_, true)) return;
      spdlog::info("stopping");
      boost::system::error_code ignored;
      signals_.cancel(ignored);
      relay_->stop();
      const Error why = {ErrorCode::kUnavailable, "The gateway stops; connect again later."};
      if (tcp_) tcp_->close(why);
      if (http_) http_->close(why);
    });
  }

 private:
  void watch_signals() {
    signals_.add(SIGINT);
    signals_.add(SIGTERM);
    signals_.async_wait([this](boost::system::error_code cancelled, int) {
      if (!cancelled) stop();
    });
  }

  RelayServerOptions options_;
  Doorkeeper keeper_;  // Outlives everything that may hold a guest.
  asio::io_context io_;
  std::shared_ptr<Relay> relay_;
  asio::signal_set signals_;
  bool is_stopping_ = false;
  std::unique_ptr<TcpDoor> tcp_;
  std::unique_ptr<HttpDoor> http_;
};

RelayServer::RelayServer(RelayServerOptions options)
    : running_(std::make_unique<Running>(std::move(options))) {}
RelayServer::~RelayServer() = default;

Endpoint RelayServer::http() const { return running_->http(); }
Endpoint RelayServer::tcp() const { return running_->tcp(); }
void RelayServer::run() { running_->run(); }
void RelayServer::stop() { running_->stop(); }

}  // namespace multitetra
