// Reservations of memory or disk space, limited in total and for each share (an address, a token).
//
//   auto reservation = queue.take("address 192.0.2.7", bytes);
//   if (!reservation) refuse();  // Otherwise reserved for the life of *reservation.
//
// A share may hold a fixed part of what the others leave, so a few shares never take everything: at
// a quarter each, six of them leave 18 % free, of which the next may take a quarter. IPv6 networks
// within a larger one jointly count for a few shares (see share_levels()).
//
// Thread-safe. Reservations may outlive this object.
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

  // `max_share_fraction`, in (0, 1]: the part of the bytes left by others that a share may hold.
  explicit ByteReservations(std::size_t capacity, double max_share_fraction = 1)
      : accounts_(std::make_shared<Accounts>()), capacity_(capacity), part_(max_share_fraction) {}
  ByteReservations(const ByteReservations&) = delete;
  ByteReservations& operator=(const ByteReservations&) = delete;

  // Returns nullopt if too few bytes are left, in total or for the share.
  [[nodiscard]] std::optional<Reservation> take(const std::string& share, std::size_t bytes);
  [[nodiscard]] std::size_t used() const {
    const std::lock_guard lock(accounts_->mutex);
    return accounts_->used;
  }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  // Returns the largest reservation of a share while no other one holds any.
  [[nodiscard]] std::size_t max_per_share() const {
    return part_ < 1 ? static_cast<std::size_t>(part_ * static_cast<double>(capacity_)) : capacity_;
  }

 private:
  struct Accounts {
    std::mutex mutex;  // Guards the other members.
    std::size_t used = 0;
    std::unordered_map<std::string, std::size_t> by_level = {};
  };

  std::shared_ptr<Accounts> accounts_;
  std::size_t capacity_;
  double part_;
};

// Releases its bytes when destroyed.
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
  std::vector<std::string> levels_;  // Names from share_levels().
  std::size_t bytes_ = 0;
};

}  // namespace multitetra
