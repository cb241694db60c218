// A listener: accepts connections on an address and owns them.
//
// Everything but endpoint() runs on the one thread of the server's io_context.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/net/endpoint.hpp"
#include "common/net/net_fwd.hpp"
#include "server/operations/admission_control.hpp"

namespace multitetra {

class Conversation;
using ConversationPtr = std::shared_ptr<Conversation>;
class SurfaceService;

class Listener {
 public:
  virtual ~Listener() = default;

  // The address it listens on, with the real port.
  [[nodiscard]] virtual Endpoint endpoint() const = 0;
  // The same as clients write it, "tls://HOST:PORT" for example.
  [[nodiscard]] virtual std::string url() const = 0;
  // Begins to accept.
  virtual void open() = 0;
  // Stops accepting, and ends the open connections with an error. The listener keeps the io_context
  // at work until the last of them has ended.
  virtual void close(const Error& why) = 0;
};

// The server as its listeners see it; it outlives them.
struct ServerContext {
  asio::io_context& io;
  AdmissionControl& admission;
  SurfaceService& service;
  std::function<ConversationPtr(ConnectionContextPtr client)> new_conversation;
  std::function<std::string()> metrics = {};  // Prometheus text; empty: none are kept.
};

using MakeListener = std::function<std::unique_ptr<Listener>(const ServerContext&)>;

}  // namespace multitetra
