// One connection of a listener, of any protocol.
#pragma once

#include <memory>
#include <optional>

#include "common/base/result.hpp"
#include "server/operations/admission_control.hpp"
#include "server/operations/deadline.hpp"

namespace multitetra {

class Connection {
 public:
  virtual ~Connection() = default;

  // Returns the start of the idle time; nullopt if busy.
  [[nodiscard]] virtual std::optional<Clock::time_point> idle_since() const = 0;
  // Sends the error if the protocol supports it, then closes the connection, at the latest after
  // the linger time.
  virtual void end(const Error& why) = 0;
  // Enforces the time limits. Called periodically, so thousands of connections share one timer
  // instead of arming several for each message.
  virtual void enforce_limits(Clock::time_point now) = 0;
};
using ConnectionPtr = std::shared_ptr<Connection>;

// Lets admission control evict the client while its connection is idle.
inline void allow_idle_eviction(ConnectionContext& client, std::weak_ptr<Connection> connection) {
  client.set_evictable({.since =
                            [connection] {
                              const ConnectionPtr one = connection.lock();
                              return one ? one->idle_since() : std::nullopt;
                            },
                        .end =
                            [connection](const Error& why) {
                              if (const ConnectionPtr one = connection.lock()) one->end(why);
                            }});
}

}  // namespace multitetra
