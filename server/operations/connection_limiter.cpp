#include "server/operations/connection_limiter.hpp"

#include <algorithm>

#include "server/operations/client_address.hpp"

namespace multitetra {

Result<ConnectionLimiter::Ticket> ConnectionLimiter::acquire() {
  if (is_full()) {
    return fail(ErrorCode::kUnavailable, "The server has reached its limit of " +
                                             std::to_string(limits_.total) +
                                             " connections; try again later.");
  }
  ++count_;
  return Ticket(this);
}

Result<ConnectionLimiter::Ticket> ConnectionLimiter::acquire(const std::string& name) {
  const std::vector<ShareLevel> levels = share_levels(name);
  for (const ShareLevel& level : levels) {
    const std::size_t limit = limits_.per_name * static_cast<std::size_t>(level.shares);
    const auto found = by_level_.find(level.name);
    if (limit == 0 || found == by_level_.end() || found->second < limit) continue;
    return fail(ErrorCode::kUnavailable,
                "There are " + std::to_string(limit) + " connections from your " +
                    (level.shares == 1 ? "address" : "network " + level.name) +
                    ", which is the limit; close one of them.");
  }
  auto ticket = acquire();
  if (!ticket || name.empty()) return ticket;
  for (const ShareLevel& level : levels) {
    ++by_level_[level.name];
    ticket->levels_.push_back(level.name);
  }
  return ticket;
}

double ConnectionLimiter::group_size_of(const std::string& name) const {
  double fullest = 0;
  for (const ShareLevel& level : share_levels(name)) {
    const auto found = by_level_.find(level.name);
    if (found == by_level_.end()) continue;
    fullest = std::max(fullest, static_cast<double>(found->second) / level.shares);
  }
  return fullest;
}

void ConnectionLimiter::release(const std::vector<std::string>& levels) {
  --count_;
  for (const std::string& level : levels) {
    const auto at = by_level_.find(level);
    if (--at->second == 0) by_level_.erase(at);
  }
}

}  // namespace multitetra
