// A gateway on a free local port, running in its own thread, and servers that it can lose.
#pragma once

#include <chrono>
#include <memory>
#include <thread>
#include <utility>

#include "server/gateway/remote_service.hpp"
#include "server/operations/log.hpp"
#include "server/routes/route_options.hpp"
#include "server/transport/server.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/running_http_server.hpp"

namespace multitetra::testing {

struct GatewayOptionsOfTest {
  UpstreamOptions upstream = {};
  UpstreamFiles upstream_files = {};
  ServerOptions server = {};
};

class RunningGateway {
 public:
  explicit RunningGateway(GatewayOptionsOfTest options)
      : gateway_(remote_service({.upstream = std::move(options.upstream),
                                 .files = std::move(options.upstream_files)}),
                 with_http_alone(std::move(options.server)),
                 {http_listener({.listen = {.host = "127.0.0.1", .port = 0}})}),
        thread_([this] { gateway_.run(); }) {}
  ~RunningGateway() {
    gateway_.stop();
    wait();
  }
  RunningGateway(const RunningGateway&) = delete;
  RunningGateway& operator=(const RunningGateway&) = delete;

  // Waits until the gateway has stopped by itself.
  void wait() {
    if (thread_.joinable()) thread_.join();
  }
  void drain() { gateway_.drain(); }
  void reload() { gateway_.reload(); }
  [[nodiscard]] Endpoint http() const { return gateway_.endpoint(); }

 private:
  static ServerOptions with_http_alone(ServerOptions options) {
    set_log_level(LogLevel::kOff);
    options.has_tcp_listener = false;
    return options;
  }
  Server gateway_;
  std::thread thread_;
};

// A server on TCP that can be stopped abruptly: its connections are cut.
class Upstream {
 public:
  explicit Upstream(std::shared_ptr<const SurfaceProvider> source, ServerOptions options = {})
      : Upstream(catalogue_of(std::move(source)), std::move(options)) {}
  explicit Upstream(CataloguePtr catalogue, ServerOptions options = {})
      : catalogue_(std::move(catalogue)), options_(std::move(options)) {
    options_.listen = {.host = "127.0.0.1", .port = 0};
    options_.connection.linger = std::chrono::milliseconds(5);
    start();
  }
  ~Upstream() { stop(); }
  Upstream(const Upstream&) = delete;
  Upstream& operator=(const Upstream&) = delete;

  void stop() {
    if (!server_) return;
    server_->stop();
    thread_.join();
    server_.reset();
  }
  // Restarts the server on the same port.
  void start_again() {
    options_.listen = endpoint_;
    start();
  }
  [[nodiscard]] const Endpoint& endpoint() const { return endpoint_; }

 private:
  void start() {
    server_ = std::make_unique<Server>(catalogue_, options_);
    endpoint_ = server_->endpoint();
    thread_ = std::thread([this] { server_->run(); });
  }
  CataloguePtr catalogue_;
  ServerOptions options_;
  std::unique_ptr<Server> server_;
  Endpoint endpoint_;
  std::thread thread_;
};

}  // namespace multitetra::testing
