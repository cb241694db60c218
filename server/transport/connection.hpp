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

  // Since when it has had nothing to do; nullopt while it has.
  [[nodiscard]] virtual std::optional<Clock::time_point> idle_since() const = 0;
  // Sends the error if the protocol has one, then closes; within the linger time the connection is
  // closed whatever the client does.
  virtual void end(const Error& why) = 0;
  // Ends what takes too long. Called again and again with the time that it is: so thousands of
  // connections share one timer instead of arming several each for every message.
  virtual void keep_time(Clock::time_point now) = 0;
};
using ConnectionPtr = std::shared_ptr<Connection>;

// A newcomer may take the client's place among the connections while this one rests.
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
