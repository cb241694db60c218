#include "server/service/server.hpp"

#include <csignal>
#include <utility>

#include "server/operations/log.hpp"
#include "server/service/workers.hpp"

namespace multitetra {

using boost::system::error_code;

// Members of one thread: everything but stop(), drain() and reload() runs in run().
class Server::Running {
 public:
  Running(CataloguePtr catalogue, ServerOptions options, const std::vector<MakeDoor>& more)
      : catalogue_(std::move(catalogue)),
        options_(std::move(options)),
        keeper_(observed(options_)),
        io_(/*concurrency_hint=*/1),
        workers_(options_.workers),
        signals_(io_),
        drain_timer_(io_) {
    options_.connection.max_message_bytes = options_.session.max_message_bytes;
    const House house = {
        .io = io_,
        .keeper = keeper_,
        .new_dialogue = [this](GuestPtr guest) { return new_dialogue(std::move(guest)); },
        .metrics =
            options_.metrics ? [this] { return metrics(); } : std::function<std::string()>()};
    doors_.push_back(std::make_unique<TcpDoor>(
        house, TcpDoorOptions{.listen = options_.listen, .connection = options_.connection}));
    for (const MakeDoor& make : more) doors_.push_back(make(house));
  }
  ~Running() { workers_.join(); }

  [[nodiscard]] Endpoint endpoint(std::size_t door) const { return doors_.at(door)->endpoint(); }

  void run() {
    if (options_.heed_signals) {
      for (const int signal : {SIGINT, SIGTERM, SIGHUP}) signals_.add(signal);
      await_signal();
    }
    for (const auto& door : doors_) door->open();
    io_.run();
    workers_.join();
  }

  void stop() {
    asio::post(io_, [this] { stop_now(); });
  }
  void drain() {
    asio::post(io_, [this] { drain_now(); });
  }
  void reload() {
    asio::post(io_, [this] { keeper_.reload(); });
  }

 private:
  static DoorkeeperOptions observed(const ServerOptions& options) {
    DoorkeeperOptions keeper = options.keeper;
    if (!options.metrics) return keeper;
    keeper.observer = keeper.observer
                          ? std::make_shared<ServiceObservers>(
                                std::vector<ServiceObserverPtr>{keeper.observer, options.metrics})
                          : ServiceObserverPtr(options.metrics);
    return keeper;
  }

  DialoguePtr new_dialogue(GuestPtr guest) {
    return std::make_shared<Conversation>(io_.get_executor(), workers_,
                                          Session(catalogue_, options_.session, keeper_.access()),
                                          std::move(guest), options_.limits);
  }

  std::string metrics() {
    ServiceState state = options_.state ? options_.state() : ServiceState{};
    state.waiting_jobs = workers_.waiting();
    state.waiting_bytes = keeper_.queue().used();
    state.datasets = catalogue_->size();
    state.is_draining = keeper_.is_draining();
    return options_.metrics->text(state);
  }

  void await_signal() {
    signals_.async_wait([this](error_code cancelled, int signal) {
      // A signal that came before the last one was heeded is told even after stop_now's cancel.
      if (cancelled || is_stopping_) return;
      if (signal == SIGHUP) {
        keeper_.reload();
      } else if (keeper_.is_draining()) {
        stop_now();
      } else {
        drain_now();
      }
      await_signal();
    });
  }

  void drain_now() {
    if (is_stopping_ || keeper_.is_draining()) return;
    log_line(LogLevel::kInfo, "draining",
             {{"connections", static_cast<std::uint64_t>(keeper_.guests())}});
    drain_timer_.expires_after(options_.drain_time);
    drain_timer_.async_wait([this](error_code cancelled) {
      if (!cancelled) stop_now();
    });
    // Not from inside the request that ends.
    keeper_.drain([this] { stop(); });
  }

  void stop_now() {
    if (is_stopping_) return;
    is_stopping_ = true;
    log_line(LogLevel::kInfo, "stopping",
             {{"connections", static_cast<std::uint64_t>(keeper_.guests())}});
    error_code ignored;
    signals_.cancel(ignored);
    drain_timer_.cancel();
    for (const auto& door : doors_) {
      door->close({ErrorCode::kUnavailable, "The server stops; connect again later."});
    }
  }

  CataloguePtr catalogue_;
  ServerOptions options_;
  Doorkeeper keeper_;  // Outlives everything that may hold a guest.
  asio::io_context io_;
  Workers workers_;
  asio::signal_set signals_;
  asio::steady_timer drain_timer_;
  bool is_stopping_ = false;
  std::vector<std::unique_ptr<Door>> doors_;
};

Server::Server(CataloguePtr catalogue, ServerOptions options, const std::vector<MakeDoor>& more)
    : running_(std::make_unique<Running>(std::move(catalogue), std::move(options), more)) {}
Server::~Server() = default;

Endpoint Server::endpoint(std::size_t door) const { return running_->endpoint(door); }
void Server::run() { running_->run(); }
void Server::stop() { running_->stop(); }
void Server::drain() { running_->drain(); }
void Server::reload() { running_->reload(); }

}  // namespace multitetra
