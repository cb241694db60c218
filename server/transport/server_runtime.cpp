#include "server/transport/server_runtime.hpp"

#include <csignal>
#include <utility>

#include <boost/asio/signal_set.hpp>

#include "common/net/coroutines.hpp"
#include "common/net/net.hpp"
#include "server/operations/heap_trimmer.hpp"
#include "server/operations/log.hpp"

namespace multitetra {

namespace {

// Other observers besides the metrics are kept.
AdmissionOptions observed(const ServerRuntimeOptions& options) {
  AdmissionOptions admission = options.admission;
  if (!options.metrics) return admission;
  admission.observer = admission.observer
                           ? std::make_shared<ServiceObservers>(std::vector<ServiceObserverPtr>{
                                 admission.observer, options.metrics})
                           : ServiceObserverPtr(options.metrics);
  return admission;
}

}  // namespace

// Members of one thread: everything but stop(), drain() and reload() runs in run().
class ServerRuntime::Running {
 public:
  explicit Running(ServerRuntimeOptions options)
      : options_(std::move(options)),
        admission_(observed(options_)),
        io_(/*concurrency_hint=*/1),
        signals_(io_),
        drain_timer_(io_),
        memory_timer_(io_) {}

  [[nodiscard]] asio::io_context& io() { return io_; }
  [[nodiscard]] AdmissionControl& admission() { return admission_; }

  void build(SurfaceService& service, ServerHooks hooks,
             const std::vector<MakeListener>& listeners) {
    hooks_ = std::move(hooks);
    const ServerContext server = {.io = io_,
                                  .admission = admission_,
                                  .service = service,
                                  .new_conversation = hooks_.new_conversation,
                                  .metrics = options_.metrics ? [this] { return metrics(); }
                                                              : std::function<std::string()>()};
    for (const MakeListener& make : listeners) listeners_.push_back(make(server));
  }
  [[nodiscard]] const std::vector<std::unique_ptr<Listener>>& listeners() const {
    return listeners_;
  }

  void run() {
    if (options_.heed_signals) {
      for (const int signal : {SIGINT, SIGTERM, SIGHUP}) signals_.add(signal);
      await_signal();
    }
    for (const auto& listener : listeners_) listener->open();
    if (options_.returns_memory) {
      spawn(io_.get_executor(), [this] { return return_memory(); });
    }
    io_.run();
  }

  void stop() {
    post(io_.get_executor(), [this] { stop_now(); });
  }
  void drain() {
    post(io_.get_executor(), [this] { drain_now(); });
  }
  void reload() {
    post(io_.get_executor(), [this] { reload_now(); });
  }

 private:
  std::string metrics() {
    ServiceState state = hooks_.state ? hooks_.state() : ServiceState{};
    state.waiting_bytes = admission_.queue().used();
    state.is_draining = admission_.is_draining();
    return options_.metrics->text(state);
  }

  asio::awaitable<void> return_memory() {
    HeapTrimmer memory;
    while (!is_stopping_) {
      const bool is_busy = admission_.running_requests() > 0;
      if (memory.is_due(HeapTrimmer::Clock::now(), admission_.requests(), is_busy)) {
        return_free_memory();
      }
      memory_timer_.expires_after(std::chrono::seconds(1));
      co_await wait_on(memory_timer_);
    }
  }

  void await_signal() {
    signals_.async_wait([this](error_code cancelled, int signal) {
      // A signal that came before the last one was handled is delivered even after stop_now's
      // cancel.
      if (cancelled || is_stopping_) return;
      if (signal == SIGHUP) {
        reload_now();
      } else if (admission_.is_draining()) {
        stop_now();
      } else {
        drain_now();
      }
      if (!is_stopping_) await_signal();  // Else it would keep the server running.
    });
  }

  void reload_now() {
    admission_.reload();
    if (hooks_.when_reloaded) hooks_.when_reloaded();
  }

  void drain_now() {
    if (is_stopping_ || admission_.is_draining()) return;
    log_line(LogLevel::kInfo, "draining",
             {{"connections", static_cast<std::uint64_t>(admission_.connections())}});
    drain_timer_.expires_after(options_.drain_time);
    when_expired(drain_timer_, [this] { stop_now(); });
    // Not from inside the request that ends.
    admission_.drain([this] { stop(); });
  }

  void stop_now() {
    if (std::exchange(is_stopping_, true)) return;
    log_line(LogLevel::kInfo, "stopping",
             {{"connections", static_cast<std::uint64_t>(admission_.connections())}});
    error_code ignored;
    signals_.cancel(ignored);
    drain_timer_.cancel();
    memory_timer_.cancel();
    if (hooks_.when_stopping) hooks_.when_stopping();
    for (const auto& listener : listeners_) {
      listener->close({ErrorCode::kUnavailable, "The server stops; connect again later."});
    }
  }

  ServerRuntimeOptions options_;
  AdmissionControl admission_;  // Outlives everything that may hold a client.
  asio::io_context io_;
  asio::signal_set signals_;
  asio::steady_timer drain_timer_;
  asio::steady_timer memory_timer_;
  bool is_stopping_ = false;
  ServerHooks hooks_;
  std::vector<std::unique_ptr<Listener>> listeners_;
};

ServerRuntime::ServerRuntime(ServerRuntimeOptions options)
    : running_(std::make_unique<Running>(std::move(options))) {}
ServerRuntime::~ServerRuntime() = default;

asio::io_context& ServerRuntime::io() { return running_->io(); }
AdmissionControl& ServerRuntime::admission() { return running_->admission(); }
void ServerRuntime::build(SurfaceService& service, ServerHooks hooks,
                          const std::vector<MakeListener>& listeners) {
  running_->build(service, std::move(hooks), listeners);
}

Endpoint ServerRuntime::endpoint(std::size_t listener) const {
  return running_->listeners().at(listener)->endpoint();
}

std::vector<std::string> ServerRuntime::urls() const {
  std::vector<std::string> urls;
  for (const auto& listener : running_->listeners()) urls.push_back(listener->url());
  return urls;
}

void ServerRuntime::run() { running_->run(); }
void ServerRuntime::stop() { running_->stop(); }
void ServerRuntime::drain() { running_->drain(); }
void ServerRuntime::reload() { running_->reload(); }

}  // namespace multitetra
