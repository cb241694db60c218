// Bytes that all share: what waits for clients may take so much memory in all, not more.
//
// One thread at a time; shares must not outlive the budget.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>

namespace multitetra {

class ByteBudget {
 public:
  class Share;

  explicit ByteBudget(std::size_t capacity) : capacity_(capacity) {}
  ByteBudget(const ByteBudget&) = delete;
  ByteBudget& operator=(const ByteBudget&) = delete;

  // nullopt when there is not so much left.
  [[nodiscard]] std::optional<Share> take(std::size_t bytes);
  [[nodiscard]] std::size_t used() const { return used_; }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }

 private:
  std::size_t capacity_;
  std::size_t used_ = 0;
};

// Gives its bytes back when it goes.
class ByteBudget::Share {
 public:
  Share() = default;
  Share(Share&& other) noexcept
      : of_(std::exchange(other.of_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
  Share& operator=(Share&& other) noexcept {
    std::swap(of_, other.of_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~Share() {
    if (of_ != nullptr) of_->used_ -= bytes_;
  }

 private:
  friend class ByteBudget;
  Share(ByteBudget* of, std::size_t bytes) : of_(of), bytes_(bytes) {}

  ByteBudget* of_ = nullptr;
  std::size_t bytes_ = 0;
};

inline std::optional<ByteBudget::Share> ByteBudget::take(std::size_t bytes) {
  if (bytes > capacity_ - used_) return std::nullopt;
  used_ += bytes;
  return Share(this, bytes);
}

}  // namespace multitetra
