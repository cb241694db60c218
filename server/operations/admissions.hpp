// How many are inside, in all and of each name (a client's address): who comes in holds a ticket
// for as long as it stays.
//
//   auto ticket = admissions.enter("192.0.2.7");
//   if (!ticket) say(ticket.error());
//
// One thread at a time; tickets must not outlive the admissions.
#pragma once

#include <cstddef>
#include <string>
#include <unordered_map>
#include <utility>

#include "common/result.hpp"

namespace multitetra {

struct AdmissionLimits {
  std::size_t total = 0;     // 0: no limit.
  std::size_t per_name = 0;  // The same.
};

class Admissions {
 public:
  class Ticket;

  explicit Admissions(AdmissionLimits limits) : limits_(limits) {}
  Admissions(const Admissions&) = delete;
  Admissions& operator=(const Admissions&) = delete;

  // kUnavailable, with a text for the client, when there are too many.
  [[nodiscard]] Result<Ticket> enter(const std::string& name);
  // Somebody who is trusted to bring many: the total counts alone.
  [[nodiscard]] Result<Ticket> enter();
  [[nodiscard]] std::size_t inside() const { return inside_; }

 private:
  void leave(const std::string& name);

  AdmissionLimits limits_;
  std::size_t inside_ = 0;
  std::unordered_map<std::string, std::size_t> by_name_;
};

class Admissions::Ticket {
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
  friend class Admissions;
  Ticket(Admissions* of, std::string name) : of_(of), name_(std::move(name)) {}

  Admissions* of_ = nullptr;
  std::string name_;
};

}  // namespace multitetra
