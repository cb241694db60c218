// One connection of a listener, whatever is spoken on it at the time.
#pragma once

#include <memory>

#include "common/base/result.hpp"
#include "server/operations/deadline.hpp"

namespace multitetra {

class Connection {
 public:
  virtual ~Connection() = default;

  // Tells why, where there are words for it, and ends; within the linger time the connection is
  // closed whatever the client does.
  virtual void end(const Error& why) = 0;
  // Ends what takes too long. Called again and again with the time that it is: so thousands of
  // connections share one timer instead of arming several each for every message.
  virtual void keep_time(Clock::time_point now) = 0;
};
using ConnectionPtr = std::shared_ptr<Connection>;

}  // namespace multitetra
