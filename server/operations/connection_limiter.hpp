// Limits connections, in all and of each name (a client's address): each holds a ticket
// for as long as it stays. Names that are IPv6 networks count for the networks around them as well
// (see share_levels()).
//
//   auto ticket = connections.enter("192.0.2.7");
//   if (!ticket) say(ticket.error());
//
// One thread at a time; tickets must not outlive the connections.
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
  std::size_t per_name = 0;  // The same.
};

class ConnectionLimiter {
 public:
  class Ticket;

  explicit ConnectionLimiter(ConnectionLimits limits) : limits_(limits) {}
  ConnectionLimiter(const ConnectionLimiter&) = delete;
  ConnectionLimiter& operator=(const ConnectionLimiter&) = delete;

  // kUnavailable, with a text for the client, when there are too many.
  [[nodiscard]] Result<Ticket> enter(const std::string& name);
  // For a trusted proxy: counts towards the total only.
  [[nodiscard]] Result<Ticket> enter();
  [[nodiscard]] std::size_t inside() const { return inside_; }
  [[nodiscard]] bool is_full() const { return limits_.total > 0 && inside_ >= limits_.total; }
  // The connections of a name; the networks around it may have more for each share that they
  // count for.
  [[nodiscard]] double group_size_of(const std::string& name) const;

 private:
  void leave(const std::vector<std::string>& levels);

  ConnectionLimits limits_;
  std::size_t inside_ = 0;
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
    if (of_ != nullptr) of_->leave(levels_);
  }

 private:
  friend class ConnectionLimiter;
  explicit Ticket(ConnectionLimiter* of) : of_(of) {}

  ConnectionLimiter* of_ = nullptr;
  std::vector<std::string> levels_;
};

}  // namespace multitetra
