#include "server/operations/connection_limiter.hpp"

namespace multitetra {

Result<ConnectionLimiter::Ticket> ConnectionLimiter::enter() {
  if (limits_.total > 0 && inside_ >= limits_.total) {
    return fail(ErrorCode::kUnavailable, "The server has its " + std::to_string(limits_.total) +
                                             " connections; try again later.");
  }
  ++inside_;
  return Ticket(this, "");
}

Result<ConnectionLimiter::Ticket> ConnectionLimiter::enter(const std::string& name) {
  const auto found = by_name_.find(name);
  if (limits_.per_name > 0 && found != by_name_.end() && found->second >= limits_.per_name) {
    return fail(ErrorCode::kUnavailable, "There are " + std::to_string(limits_.per_name) +
                                             " connections from your address, the most that one "
                                             "may have; close one of them.");
  }
  auto ticket = enter();
  if (!ticket) return ticket;
  if (!name.empty()) ++by_name_[name];
  ticket->name_ = name;
  return ticket;
}

void ConnectionLimiter::leave(const std::string& name) {
  --inside_;
  if (name.empty()) return;
  const auto at = by_name_.find(name);
  if (--at->second == 0) by_name_.erase(at);
}

}  // namespace multitetra
