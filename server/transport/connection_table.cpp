#include "server/transport/connection_table.hpp"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "common/net/coroutines.hpp"

namespace multitetra {

// Polls often enough to exceed no limit by much more than a tenth, at negligible cost.
ConnectionTable::ConnectionTable(asio::io_context& io, std::chrono::milliseconds shortest)
    : pause_(std::clamp<std::chrono::milliseconds>(shortest / 8, std::chrono::milliseconds(5),
                                                   std::chrono::milliseconds(250))),
      timer_(io) {}

void ConnectionTable::start() {
  spawn(timer_.get_executor(), [this] { return enforce_limits(); });
}

void ConnectionTable::put(std::uint64_t id, ConnectionPtr connection) {
  connections_[id] = connection;
  if (closed_) connection->end(*closed_);
}

void ConnectionTable::remove(std::uint64_t id) {
  connections_.erase(id);
  if (closed_) timer_.cancel();
}

void ConnectionTable::close(const Error& why) {
  closed_ = why;
  timer_.cancel();
  // A connection that ends at once is removed from the map, so iterate over a copy.
  std::vector<ConnectionPtr> all;
  for (const auto& [id, connection] : connections_) all.push_back(connection);
  for (const ConnectionPtr& connection : all) connection->end(why);
}

asio::awaitable<void> ConnectionTable::enforce_limits() {
  while (!closed_ || !connections_.empty()) {
    timer_.expires_after(pause_);
    co_await wait_on(timer_);
    const Clock::time_point now = Clock::now();
    // Connections are not removed during this loop, as coroutines report their ends later.
    for (const auto& [id, connection] : connections_) connection->enforce_limits(now);
  }
}

}  // namespace multitetra
