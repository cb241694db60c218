#include "server/transport/connection_table.hpp"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "common/net/coroutines.hpp"

namespace multitetra {

// Often enough that no limit is exceeded by more than a tenth or so, and seldom enough to cost
// nothing.
ConnectionTable::ConnectionTable(asio::io_context& io, std::chrono::milliseconds shortest)
    : pause_(std::clamp<std::chrono::milliseconds>(shortest / 8, std::chrono::milliseconds(5),
                                                   std::chrono::milliseconds(250))),
      timer_(io) {}

void ConnectionTable::start() {
  spawn(timer_.get_executor(), [this] { return keep_time(); });
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
  // A connection that ends at once is removed from the map while it is walked.
  std::vector<ConnectionPtr> all;
  for (const auto& [id, connection] : connections_) all.push_back(connection);
  for (const ConnectionPtr& connection : all) connection->end(why);
}

asio::awaitable<void> ConnectionTable::keep_time() {
  while (!closed_ || !connections_.empty()) {
    timer_.expires_after(pause_);
    co_await wait_on(timer_);
    const Clock::time_point now = Clock::now();
    // No connection leaves the map here: coroutines report their ends later.
    for (const auto& [id, connection] : connections_) connection->keep_time(now);
  }
}

}  // namespace multitetra
