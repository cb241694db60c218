#include "server/service/reception.hpp"

#include <csignal>
#include <utility>

#include "server/operations/log.hpp"

namespace multitetra {

using boost::system::error_code;

namespace {

// Whoever is told besides the metrics goes on being told.
DoorkeeperOptions observed(const ReceptionOptions& options) {
  DoorkeeperOptions keeper = options.keeper;
  if (!options.metrics) return keeper;
  keeper.observer = keeper.observer
                        ? std::make_shared<ServiceObservers>(
                              std::vector<ServiceObserverPtr>{keeper.observer, options.metrics})
                        : ServiceObserverPtr(options.metrics);
  return keeper;
}

}  // namespace

// Members of one thread: everything but stop(), drain() and reload() runs in run().
class Reception::Running {
 public:
  explicit Running(ReceptionOptions options)
      : options_(std::move(options)),
        keeper_(observed(options_)),
        io_(/*concurrency_hint=*/1),
        signals_(io_),
        drain_timer_(io_) {}

  [[nodiscard]] asio::io_context& io() { return io_; }
  [[nodiscard]] Doorkeeper& keeper() { return keeper_; }

  void build(BehindDoors behind, const std::vector<MakeDoor>& doors) {
    behind_ = std::move(behind);
    const House house = {.io = io_,
                         .keeper = keeper_,
                         .new_dialogue = behind_.new_dialogue,
                         .metrics = options_.metrics ? [this] { return metrics(); }
                                                     : std::function<std::string()>()};
    for (const MakeDoor& make : doors) doors_.push_back(make(house));
  }
  [[nodiscard]] const std::vector<std::unique_ptr<Door>>& doors() const { return doors_; }

  void run() {
    if (options_.heed_signals) {
      for (const int signal : {SIGINT, SIGTERM, SIGHUP}) signals_.add(signal);
      await_signal();
    }
    for (const auto& door : doors_) door->open();
    io_.run();
  }

  void stop() {
    asio::post(io_, [this] { stop_now(); });
  }
  void drain() {
    asio::post(io_, [this] { drain_now(); });
  }
  void reload() {
    asio::post(io_, [this] { reload_now(); });
  }

 private:
  std::string metrics() {
    ServiceState state = behind_.state ? behind_.state() : ServiceState{};
    state.waiting_bytes = keeper_.queue().used();
    state.is_draining = keeper_.is_draining();
    return options_.metrics->text(state);
  }

  void await_signal() {
    signals_.async_wait([this](error_code cancelled, int signal) {
      // A signal that came before the last one was heeded is told even after stop_now's cancel.
      if (cancelled || is_stopping_) return;
      if (signal == SIGHUP) {
        reload_now();
      } else if (keeper_.is_draining()) {
        stop_now();
      } else {
        drain_now();
      }
      if (!is_stopping_) await_signal();  // Else it would keep the server running.
    });
  }

  void reload_now() {
    keeper_.reload();
    if (behind_.when_reloaded) behind_.when_reloaded();
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
    if (std::exchange(is_stopping_, true)) return;
    log_line(LogLevel::kInfo, "stopping",
             {{"connections", static_cast<std::uint64_t>(keeper_.guests())}});
    error_code ignored;
    signals_.cancel(ignored);
    drain_timer_.cancel();
    if (behind_.when_stopping) behind_.when_stopping();
    for (const auto& door : doors_) {
      door->close({ErrorCode::kUnavailable, "The server stops; connect again later."});
    }
  }

  ReceptionOptions options_;
  Doorkeeper keeper_;  // Outlives everything that may hold a guest.
  asio::io_context io_;
  asio::signal_set signals_;
  asio::steady_timer drain_timer_;
  bool is_stopping_ = false;
  BehindDoors behind_;
  std::vector<std::unique_ptr<Door>> doors_;
};

Reception::Reception(ReceptionOptions options)
    : running_(std::make_unique<Running>(std::move(options))) {}
Reception::~Reception() = default;

asio::io_context& Reception::io() { return running_->io(); }
Doorkeeper& Reception::keeper() { return running_->keeper(); }
void Reception::build(BehindDoors behind, const std::vector<MakeDoor>& doors) {
  running_->build(std::move(behind), doors);
}

Endpoint Reception::endpoint(std::size_t door) const {
  return running_->doors().at(door)->endpoint();
}

std::vector<std::string> Reception::urls() const {
  std::vector<std::string> urls;
  for (const auto& door : running_->doors()) urls.push_back(door->url());
  return urls;
}

void Reception::run() { running_->run(); }
void Reception::stop() { running_->stop(); }
void Reception::drain() { running_->drain(); }
void Reception::reload() { running_->reload(); }

}  // namespace multitetra
