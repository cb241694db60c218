// Limits the number of connections, in total and per name (a client's address). Each connection
// holds a ticket. IPv6 networks also count for the networks around them (see share_levels()).
//
//   auto ticket = connections.acquire("192.0.2.7");
//   if (!ticket) say(ticket.error());
//
// Not thread-safe. Must outlive its tickets.
#pragma once

#include <cstddef>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/base/result.hpp"

namespace multitetra {

struct ConnectionLimits {
  std::size_t total = 0;     // 0: no limit.
  std::size_t per_name = 0;  // 0: no limit.
};

class ConnectionLimiter {
 public:
  class Ticket;

  explicit ConnectionLimiter(ConnectionLimits limits) : limits_(limits) {}
  ConnectionLimiter(const ConnectionLimiter&) = delete;
  ConnectionLimiter& operator=(const ConnectionLimiter&) = delete;

  // Returns kUnavailable, with a text for the client, above a limit.
  [[nodiscard]] Result<Ticket> acquire(const std::string& name);
  // Counts towards the total only, for trusted proxies.
  [[nodiscard]] Result<Ticket> acquire();
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] bool is_full() const { return limits_.total > 0 && count_ >= limits_.total; }
  // Returns the connections of a name, or of a network around it divided by the shares that it
  // counts for, if that is more.
  [[nodiscard]] double group_size_of(const std::string& name) const;

 private:
  void release(const std::vector<std::string>& levels);

  ConnectionLimits limits_;
  std::size_t count_ = 0;
  std::unordered_map<std::string, std::size_t> by_level_;
};

class ConnectionLimiter::Ticket {
 public:
  Ticket() = default;
  Ticket(Ticket&& other) noexcept
      : of_(std::exchange(other.of_, nullptr)), levels_(std::move(other.levels_)) {}
  Ticket& operator=(Ticket&& other) noexcept {
    std::swap(of_, other.of_);
    std::swap(levels_, other.levels_);
    return *this;
  }
  ~Ticket() {
    if (of_ != nullptr) of_->release(levels_);
  }

 private:
  friend class ConnectionLimiter;
  explicit Ticket(ConnectionLimiter* of) : of_(of) {}

  ConnectionLimiter* of_ = nullptr;
  std::vector<std::string> levels_;
};

}  // namespace multitetra
