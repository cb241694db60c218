// A listener that puts another transport in front of a server with frames over TCP: converts
// WebSocket messages or TLS streams to frames, and back. If the server cuts a frame, the part is
// passed on as part of a message.
#pragma once

#include <memory>
#include <string>

#include "common/net/endpoint.hpp"
#include "common/net/trust.hpp"

namespace multitetra::testing {

// How the listener answers a WebSocket handshake, and how it frames messages.
struct ListenerManners {
  std::string subprotocol = std::string(kSubprotocol);  // Empty for none.
  int status = 101;
  bool text_messages = false;
  std::string certificate_names = "DNS:localhost,IP:127.0.0.1";
};

class TransportListener {
 public:
  TransportListener(Transport transport, Endpoint server, ListenerManners manners = {});
  ~TransportListener();
  TransportListener(const TransportListener&) = delete;
  TransportListener& operator=(const TransportListener&) = delete;

  [[nodiscard]] Endpoint endpoint() const { return at("127.0.0.1"); }
  [[nodiscard]] Endpoint at(std::string host) const;
  // Accepts only this listener's certificate.
  [[nodiscard]] Trust trust() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace multitetra::testing
