// Reservations of memory (or disk): how much all clients may hold together, and how much of it one
// share (an address, a token) may hold.
//
//   auto reservation = queue.take("address 192.0.2.7", bytes);
//   if (!reservation) refuse();  // Else the bytes are reserved while *reservation lives.
//
// A share may hold a part of what the others leave. So a few shares never take all: with a quarter
// each, six of them leave 18 % free, of which the next one may have a quarter. Several IPv6
// networks of one network around them (see share_levels()) count for a few shares together.
//
// Safe to use from several threads at once. Reservations may outlive this.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace multitetra {

class ByteReservations {
 public:
  class Reservation;

  // `part_of_a_share`, above 0 and at most 1, of what the others leave is what a share may hold.
  explicit ByteReservations(std::size_t capacity, double part_of_a_share = 1)
      : accounts_(std::make_shared<Accounts>()), capacity_(capacity), part_(part_of_a_share) {}
  ByteReservations(const ByteReservations&) = delete;
  ByteReservations& operator=(const ByteReservations&) = delete;

  // nullopt when there is not so much left, in all or for the share.
  [[nodiscard]] std::optional<Reservation> take(const std::string& share, std::size_t bytes);
  [[nodiscard]] std::size_t used() const {
    const std::lock_guard lock(accounts_->mutex);
    return accounts_->used;
  }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  // While no other share holds anything.
  [[nodiscard]] std::size_t most_of_a_share() const {
    return part_ < 1 ? static_cast<std::size_t>(part_ * static_cast<double>(capacity_)) : capacity_;
  }

 private:
  struct Accounts {
    std::mutex mutex;  // Guards the rest.
    std::size_t used = 0;
    std::unordered_map<std::string, std::size_t> by_level = {};
  };

  std::shared_ptr<Accounts> accounts_;
  std::size_t capacity_;
  double part_;
};

// Gives its bytes back when it goes.
class ByteReservations::Reservation {
 public:
  Reservation() = default;
  Reservation(Reservation&& other) noexcept { swap(other); }
  Reservation& operator=(Reservation&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Reservation();
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  friend class ByteReservations;
  Reservation(std::shared_ptr<Accounts> accounts, std::vector<std::string> levels,
              std::size_t bytes)
      : accounts_(std::move(accounts)), levels_(std::move(levels)), bytes_(bytes) {}
  void swap(Reservation& other) noexcept {
    std::swap(accounts_, other.accounts_);
    std::swap(levels_, other.levels_);
    std::swap(bytes_, other.bytes_);
  }

  std::shared_ptr<Accounts> accounts_;
  std::vector<std::string> levels_;  // Names of share_levels().
  std::size_t bytes_ = 0;
};

}  // namespace multitetra
