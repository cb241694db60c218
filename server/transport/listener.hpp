// Accepts connections on an address and owns them.
//
// Except endpoint(), everything runs on the thread of the server's io_context.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/net/endpoint.hpp"
#include "common/net/net_fwd.hpp"
#include "server/operations/admission_control.hpp"

namespace multitetra {

class SessionRunner;
using SessionRunnerPtr = std::shared_ptr<SessionRunner>;
class SurfaceService;

class Listener {
 public:
  virtual ~Listener() = default;

  // Returns the address with the actual port.
  [[nodiscard]] virtual Endpoint endpoint() const = 0;
  // Returns the address as clients write it, for example "tls://HOST:PORT".
  [[nodiscard]] virtual std::string url() const = 0;
  // Begins to accept connections.
  virtual void open() = 0;
  // Stops accepting, and ends open connections with an error. Keeps the io_context running until
  // the last one has ended.
  virtual void close(const Error& why) = 0;
};

// The server as seen by its listeners. Outlives them.
struct ServerContext {
  asio::io_context& io;
  AdmissionControl& admission;
  SurfaceService& service;
  std::function<SessionRunnerPtr(ConnectionContextPtr client)> new_session_runner;
  // Returns Prometheus text; empty: no metrics.
  std::function<std::string()> metrics = {};
};

using MakeListener = std::function<std::unique_ptr<Listener>(const ServerContext&)>;

}  // namespace multitetra
