// A way in: something that accepts connections on an address and holds them.
//
// Everything but endpoint() runs on the one thread of the house's io_context.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/endpoint.hpp"
#include "server/operations/doorkeeper.hpp"
#include "server/service/dialogue.hpp"

namespace multitetra {

class Door {
 public:
  virtual ~Door() = default;

  // The address it listens on, with the real port.
  [[nodiscard]] virtual Endpoint endpoint() const = 0;
  // The same as clients write it, "tls://HOST:PORT" for example.
  [[nodiscard]] virtual std::string url() const = 0;
  // Begins to accept.
  virtual void open() = 0;
  // Accepts nobody any more and ends the connections that are there: they are told why. The door
  // keeps the io_context at work until the last of them has gone.
  virtual void close(const Error& why) = 0;
};

// What a door leads into. The house outlives its doors.
struct House {
  asio::io_context& io;
  Doorkeeper& keeper;
  std::function<DialoguePtr(GuestPtr guest)> new_dialogue;
  std::function<std::string()> metrics = {};  // Prometheus text; empty: none are kept.
};

using MakeDoor = std::function<std::unique_ptr<Door>(const House&)>;

}  // namespace multitetra
