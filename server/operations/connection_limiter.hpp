// How many are inside, in all and of each name (a client's address): who comes in holds a ticket
// for as long as it stays.
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
  // Somebody who is trusted to bring many: the total counts alone.
  [[nodiscard]] Result<Ticket> enter();
  [[nodiscard]] std::size_t inside() const { return inside_; }

 private:
  void leave(const std::string& name);

  ConnectionLimits limits_;
  std::size_t inside_ = 0;
  std::unordered_map<std::string, std::size_t> by_name_;
};

class ConnectionLimiter::Ticket {
 public:
  Ticket() = default;
  Ticket(Ticket&& other) noexcept
      : of_(std::exchange(other.of_, nullptr)), name_(std::move(other.name_)) {}
  Ticket& operator=(Ticket&& other) noexcept {
    std::swap(of_, other.of_);
    std::swap(name_, other.name_);
    return *this;
  }
  ~Ticket() {
    if (of_ != nullptr) of_->leave(name_);
  }

 private:
  friend class ConnectionLimiter;
  Ticket(ConnectionLimiter* of, std::string name) : of_(of), name_(std::move(name)) {}

  ConnectionLimiter* of_ = nullptr;
  std::string name_;
};

}  // namespace multitetra
