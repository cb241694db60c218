// Bytes that all have together: what waits may take so much of memory (or disk) in all, and what
// waits for one share (an address, a token) so much of it.
//
//   auto room = queue.take("address 192.0.2.7", bytes);
//   if (!room) refuse();      // else they are taken as long as *room lives
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

namespace multitetra {

class ByteReservations {
 public:
  class Reservation;

  // `most_of_a_share` of the capacity at most; without it a share may take all.
  explicit ByteReservations(std::size_t capacity,
                            std::optional<std::size_t> most_of_a_share = std::nullopt)
      : books_(std::make_shared<Books>()),
        capacity_(capacity),
        most_of_a_share_(most_of_a_share.value_or(capacity)) {}
  ByteReservations(const ByteReservations&) = delete;
  ByteReservations& operator=(const ByteReservations&) = delete;

  // nullopt when there is not so much left, in all or of the share.
  [[nodiscard]] std::optional<Reservation> take(const std::string& share, std::size_t bytes);
  [[nodiscard]] std::size_t used() const {
    const std::lock_guard lock(books_->mutex);
    return books_->used;
  }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  [[nodiscard]] std::size_t most_of_a_share() const { return most_of_a_share_; }

 private:
  struct Books {
    std::mutex mutex;  // Guards the rest.
    std::size_t used = 0;
    std::unordered_map<std::string, std::size_t> by_share = {};
  };

  std::shared_ptr<Books> books_;
  std::size_t capacity_;
  std::size_t most_of_a_share_;
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
  ~Reservation() {
    if (!books_) return;
    const std::lock_guard lock(books_->mutex);
    books_->used -= bytes_;
    const auto mine = books_->by_share.find(share_);
    if ((mine->second -= bytes_) == 0) books_->by_share.erase(mine);
  }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  friend class ByteReservations;
  Reservation(std::shared_ptr<Books> books, std::string share, std::size_t bytes)
      : books_(std::move(books)), share_(std::move(share)), bytes_(bytes) {}
  void swap(Reservation& other) noexcept {
    std::swap(books_, other.books_);
    std::swap(share_, other.share_);
    std::swap(bytes_, other.bytes_);
  }

  std::shared_ptr<Books> books_;
  std::string share_;
  std::size_t bytes_ = 0;
};

inline std::optional<ByteReservations::Reservation> ByteReservations::take(const std::string& share,
                                                                           std::size_t bytes) {
  if (bytes == 0) return Reservation();
  const std::lock_guard lock(books_->mutex);
  const auto known = books_->by_share.find(share);
  const std::size_t of_share = known == books_->by_share.end() ? 0 : known->second;
  if (bytes > capacity_ - books_->used) return std::nullopt;
  if (of_share > most_of_a_share_ || bytes > most_of_a_share_ - of_share) return std::nullopt;
  books_->by_share[share] += bytes;
  books_->used += bytes;
  return Reservation(books_, share, bytes);
}

}  // namespace multitetra
