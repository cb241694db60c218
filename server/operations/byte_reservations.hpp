// Bytes that all share: what waits for clients may take so much memory in all, not more.
//
// One thread at a time; reservations must not outlive this.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>

namespace multitetra {

class ByteReservations {
 public:
  class Reservation;

  explicit ByteReservations(std::size_t capacity) : capacity_(capacity) {}
  ByteReservations(const ByteReservations&) = delete;
  ByteReservations& operator=(const ByteReservations&) = delete;

  // nullopt when there is not so much left.
  [[nodiscard]] std::optional<Reservation> take(std::size_t bytes);
  [[nodiscard]] std::size_t used() const { return used_; }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }

 private:
  std::size_t capacity_;
  std::size_t used_ = 0;
};

// Gives its bytes back when it goes.
class ByteReservations::Reservation {
 public:
  Reservation() = default;
  Reservation(Reservation&& other) noexcept
      : of_(std::exchange(other.of_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
  Reservation& operator=(Reservation&& other) noexcept {
    std::swap(of_, other.of_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~Reservation() {
    if (of_ != nullptr) of_->used_ -= bytes_;
  }

 private:
  friend class ByteReservations;
  Reservation(ByteReservations* of, std::size_t bytes) : of_(of), bytes_(bytes) {}

  ByteReservations* of_ = nullptr;
  std::size_t bytes_ = 0;
};

inline std::optional<ByteReservations::Reservation> ByteReservations::take(std::size_t bytes) {
  if (bytes > capacity_ - used_) return std::nullopt;
  used_ += bytes;
  return Reservation(this, bytes);
}

}  // namespace multitetra
