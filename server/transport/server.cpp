#include "server/transport/server.hpp"

#include <algorithm>
#include <cassert>
#include <csignal>
#include <optional>
#include <utility>

#include <boost/asio/signal_set.hpp>

#include "common/net/coroutines.hpp"
#include "common/net/net.hpp"
#include "server/conversation/session_runner.hpp"
#include "server/operations/heap_trimmer.hpp"
#include "server/operations/log.hpp"
#include "server/transport/longest_task.hpp"
#include "server/transport/tcp_listener.hpp"

namespace multitetra {

namespace {

// Adds the metrics to any other observer.
AdmissionOptions observed(const ServerOptions& options) {
  AdmissionOptions admission = options.admission;
  if (!options.metrics) return admission;
  admission.observer = admission.observer
                           ? std::make_shared<ServiceObservers>(std::vector<ServiceObserverPtr>{
                                 admission.observer, options.metrics})
                           : ServiceObserverPtr(options.metrics);
  return admission;
}

// Logs patterns of the tokens file that match no dataset, as most are typing errors.
void warn_of_idle_patterns(const AccessList& list, const DatasetCatalogue& catalogue) {
  const DatasetCatalogue::Entries& datasets = catalogue.entries();
  const auto warn = [&](const AccessRights& rights) {
    for (const std::string& pattern : rights.datasets()) {
      const bool is_used = std::any_of(datasets.begin(), datasets.end(), [&](const auto& dataset) {
        return matches(pattern, dataset.first);
      });
      if (is_used || pattern == "*") continue;
      log_line(LogLevel::kWarning, "a pattern of the tokens file matches no dataset",
               {{"name", rights.name()}, {"datasets", pattern}});
    }
  };
  for (const AccessList::Entry& entry : list.entries()) warn(entry.rights);
  for (const AccessRights& rights : list.anonymous()) warn(rights);
}

}  // namespace

// Single-threaded: everything but stop(), drain() and reload() runs in run().
class Server::Running {
 public:
  Running(const MakeService& make_service, ServerOptions options,
          const std::vector<MakeListener>& more)
      : options_(std::move(options)),
        admission_(observed(options_)),
        io_(/*concurrency_hint=*/1),
        signals_(io_),
        drain_timer_(io_),
        memory_timer_(io_),
        service_(make_service(io_.get_executor())) {
    const ServerContext server = {
        .io = io_,
        .admission = admission_,
        .service = *service_,
        .new_session_runner =
            [this](ConnectionContextPtr client) { return new_session_runner(std::move(client)); },
        .metrics =
            options_.metrics ? [this] { return metrics(); } : std::function<std::string()>()};
    if (options_.has_tcp_listener) {
      listeners_.push_back(std::make_unique<TcpListener>(
          server,
          TcpListenerOptions{.listen = options_.listen, .connection = options_.connection}));
    }
    for (const MakeListener& make : more) listeners_.push_back(make(server));
  }

  [[nodiscard]] const std::vector<std::unique_ptr<Listener>>& listeners() const {
    return listeners_;
  }

  void run() {
    if (options_.handles_signals) {
      for (const int signal : {SIGINT, SIGTERM, SIGHUP}) signals_.add(signal);
      await_signal();
    }
    for (const auto& listener : listeners_) listener->open();
    if (options_.returns_memory) {
      spawn(io_.get_executor(), [this] { return return_memory(); });
    }
    service_->start();
    longest_task_.emplace();
    while (io_.run_one() > 0) longest_task_->task_ended();
    service_->join();
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
  void offer(CataloguePtr catalogue, bool is_complete) {
    post(io_.get_executor(), [this, catalogue = std::move(catalogue), is_complete] {
      auto* datasets = dynamic_cast<LocalService*>(service_.get());
      assert(datasets);
      datasets->offer(catalogue);
      admission_.observer().reloaded("datasets", !is_complete);
      warn_about(*catalogue);
    });
  }
  void keep_datasets(std::string why) {
    post(io_.get_executor(), [this, why = std::move(why)] {
      log_line(LogLevel::kError, "the previous datasets stay in use: " + why, {});
      admission_.observer().reloaded("datasets", /*failed=*/true);
    });
  }
  // Logs patterns of the tokens file that match no dataset.
  void warn_about(const DatasetCatalogue& catalogue) const {
    if (admission_.access()) warn_of_idle_patterns(*admission_.access(), catalogue);
  }

 private:
  SessionRunnerPtr new_session_runner(ConnectionContextPtr client) {
    const ServiceClientPtr service_client = service_->open(client);
    return std::make_shared<SessionRunner>(
        io_.get_executor(), service_client,
        Session(
            service_client->catalogue(), options_.session, admission_.access(),
            [service_client] { return service_client->catalogue(); }, service_client->limits()),
        std::move(client), options_.idle_time);
  }

  std::string metrics() {
    ServiceState state = service_->state();
    state.waiting_bytes = admission_.queue().used();
    state.is_draining = admission_.is_draining();
    if (longest_task_) state.longest_task_seconds = longest_task_->seconds();
    if (admission_.tls()) state.certificate_expires = expiry_of(*admission_.tls());
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
      // A signal that is already queued is delivered even after stop_now() cancels the wait.
      if (cancelled || is_stopping_) return;
      if (signal == SIGHUP && !options_.ends_on_hangup) {
        reload_now();
      } else if (admission_.is_draining()) {
        stop_now();
      } else {
        drain_now();
      }
      if (!is_stopping_) await_signal();  // Waiting would keep the server running.
    });
  }

  void reload_now() {
    admission_.reload();
    admission_.observer().reloaded("credentials", !service_->reload());
    if (options_.when_reloaded) options_.when_reloaded();
  }

  void drain_now() {
    if (is_stopping_ || admission_.is_draining()) return;
    log_line(LogLevel::kInfo, "draining",
             {{"connections", static_cast<std::uint64_t>(admission_.connections())}});
    drain_timer_.expires_after(options_.drain_time);
    when_expired(drain_timer_, [this] { stop_now(); });
    // Posted, as it may be called from within the ending request.
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
    service_->stop();
    for (const auto& listener : listeners_) {
      listener->close({ErrorCode::kUnavailable, "The server is stopping; connect again later."});
    }
  }

  ServerOptions options_;
  AdmissionControl admission_;  // Outlives everything that may hold a client.
  asio::io_context io_;
  asio::signal_set signals_;
  asio::steady_timer drain_timer_;
  asio::steady_timer memory_timer_;
  bool is_stopping_ = false;
  std::optional<LongestTask> longest_task_;  // Since run() began.
  std::vector<std::unique_ptr<Listener>> listeners_;
  // Destroyed first: joins threads that post to the members above.
  std::unique_ptr<SurfaceService> service_;
};

Server::Server(const MakeService& make_service, ServerOptions options,
               const std::vector<MakeListener>& more)
    : running_(std::make_unique<Running>(make_service, std::move(options), more)) {}
Server::Server(CataloguePtr catalogue, ServerOptions options, const std::vector<MakeListener>& more)
    : Server(
          [&](asio::any_io_executor executor) {
            return std::make_unique<LocalService>(std::move(executor), catalogue, options.service);
          },
          options, more) {
  running_->warn_about(*catalogue);
}
Server::~Server() = default;

Endpoint Server::endpoint(std::size_t listener) const {
  return running_->listeners().at(listener)->endpoint();
}

std::vector<std::string> Server::urls() const {
  std::vector<std::string> urls;
  for (const auto& listener : running_->listeners()) urls.push_back(listener->url());
  return urls;
}

void Server::run() { running_->run(); }
void Server::stop() { running_->stop(); }
void Server::drain() { running_->drain(); }
void Server::reload() { running_->reload(); }
void Server::offer(CataloguePtr catalogue, bool is_complete) {
  running_->offer(std::move(catalogue), is_complete);
}
void Server::keep_datasets(std::string why) { running_->keep_datasets(std::move(why)); }

}  // namespace multitetra
