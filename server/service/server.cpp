#include "server/service/server.hpp"

#include <csignal>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/service/conversation.hpp"
#include "server/service/workers.hpp"

namespace multitetra {

using boost::system::error_code;

// Members of one thread: everything but stop() runs in run().
class Server::Running {
 public:
  Running(CataloguePtr catalogue, ServerOptions options, const std::vector<MakeDoor>& more)
      : catalogue_(std::move(catalogue)),
        options_(std::move(options)),
        io_(/*concurrency_hint=*/1),
        workers_(options_.workers),
        signals_(io_) {
    options_.connection.max_message_bytes = options_.session.max_message_bytes;
    const House house = {.io = io_, .new_dialogue = [this](std::string peer) -> DialoguePtr {
                           return std::make_shared<Conversation>(
                               io_.get_executor(), workers_, Session(catalogue_, options_.session),
                               std::move(peer));
                         }};
    doors_.push_back(
        std::make_unique<TcpDoor>(house, TcpDoorOptions{.listen = options_.listen,
                                                        .max_connections = options_.max_connections,
                                                        .tls = options_.tls,
                                                        .connection = options_.connection}));
    for (const MakeDoor& make : more) doors_.push_back(make(house));
  }
  ~Running() { workers_.join(); }

  [[nodiscard]] Endpoint endpoint(std::size_t door) const { return doors_.at(door)->endpoint(); }

  void run() {
    if (options_.stop_on_signals) watch_signals();
    for (const auto& door : doors_) door->open();
    io_.run();
    workers_.join();
  }

  void stop() {
    asio::post(io_, [this] {
      if (is_stopping_) return;
      is_stopping_ = true;
      spdlog::info("stopping");
      error_code ignored;
      signals_.cancel(ignored);
      for (const auto& door : doors_) {
        door->close({ErrorCode::kUnavailable, "The server stops; connect again later."});
      }
    });
  }

 private:
  void watch_signals() {
    signals_.add(SIGINT);
    signals_.add(SIGTERM);
    signals_.async_wait([this](error_code cancelled, int) {
      if (!cancelled) stop();
    });
  }

  CataloguePtr catalogue_;
  ServerOptions options_;
  asio::io_context io_;
  Workers workers_;
  asio::signal_set signals_;
  bool is_stopping_ = false;
  std::vector<std::unique_ptr<Door>> doors_;
};

Server::Server(CataloguePtr catalogue, ServerOptions options, const std::vector<MakeDoor>& more)
    : running_(std::make_unique<Running>(std::move(catalogue), std::move(options), more)) {}
Server::~Server() = default;

Endpoint Server::endpoint(std::size_t door) const { return running_->endpoint(door); }
void Server::run() { running_->run(); }
void Server::stop() { running_->stop(); }

}  // namespace multitetra
