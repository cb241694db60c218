// Adaptive binary range coding in 32-bit integers, with a second stream for incompressible bits.
//
// The coder keeps an interval of numbers. A bit divides it at (range >> 15) * P(1) and keeps the
// lower part for a 1, the upper one for a 0; whenever the range has fewer than 24 bits, a byte is
// written or read. The encoder writes some number of the last interval without trailing zero bytes,
// which the decoder supplies.
#pragma once

#include <stddef.h>
#include <stdint.h>

namespace multitetra::shell {

// The probability that a bit is 1, in units of 2^-15: the mean of a fast and a slow moving average.
struct Probability {
  uint16_t fast = 1U << 14;
  uint16_t slow = 1U << 14;

  [[nodiscard]] uint32_t of_one() const {
    const uint32_t mean = (uint32_t{fast} + slow) >> 1;
    return mean < kMin ? kMin : mean > kOne - kMin ? kOne - kMin : mean;
  }
  void learn_one() {
    fast = static_cast<uint16_t>(fast + ((kOne - fast) >> kFastRate));
    slow = static_cast<uint16_t>(slow + ((kOne - slow) >> kSlowRate));
  }
  void learn_zero() {
    fast = static_cast<uint16_t>(fast - (fast >> kFastRate));
    slow = static_cast<uint16_t>(slow - (slow >> kSlowRate));
  }

  static constexpr uint32_t kOne = 1U << 15;
  static constexpr uint32_t kMin = 64;
  static constexpr int kFastRate = 4;
  static constexpr int kSlowRate = 7;
};

// Below this range a byte is written or read.
inline constexpr uint32_t kMinRange = 1U << 24;

// Reads bytes sequentially, and zeros after the end.
struct ByteReader {
  const uint8_t* next = nullptr;
  const uint8_t* end = nullptr;
  uint32_t missing = 0;  // Zeros read after the end.

  uint32_t byte() {
    if (next != end) return *next++;
    ++missing;
    return 0;
  }
};

class RangeDecoder {
 public:
  static constexpr bool kEncodes = false;
  // The encoder omits at most as many bytes as it flushes.
  static constexpr uint32_t kMaxMissing = 4;

  RangeDecoder() = default;
  RangeDecoder(const uint8_t* bytes, size_t size, const uint8_t* raw, size_t raw_size)
      : bytes_{bytes, bytes + size}, raw_{raw, raw + raw_size} {
    for (int i = 0; i < 4; ++i) code_ = code_ << 8 | bytes_.byte();
  }

  bool bit(Probability& p, bool = false) {
    const uint32_t bound = (range_ >> 15) * p.of_one();
    const bool one = code_ < bound;
    if (one) {
      range_ = bound;
      p.learn_one();
    } else {
      code_ -= bound;
      range_ -= bound;
      p.learn_zero();
    }
    while (range_ < kMinRange) {
      range_ <<= 8;
      code_ = code_ << 8 | bytes_.byte();
    }
    return one;
  }

  // Reads `count` bits, 1 to 25, lowest first.
  uint32_t raw_bits(int count, uint32_t = 0) {
    while (kept_ < count) {
      raw_word_ |= raw_.byte() << kept_;
      kept_ += 8;
    }
    const uint32_t bits = raw_word_ & ((1U << count) - 1);
    raw_word_ >>= count;
    kept_ -= count;
    return bits;
  }

  // Returns whether the bits used up exactly all bytes.
  [[nodiscard]] bool is_used_up() const {
    return bytes_.next == bytes_.end && bytes_.missing <= kMaxMissing && raw_.next == raw_.end &&
           raw_.missing == 0;
  }

  // Returns whether more bits were read than the bytes can hold: further samples are meaningless.
  [[nodiscard]] bool is_overrun() const { return bytes_.missing > kMaxMissing || raw_.missing > 0; }

 private:
  ByteReader bytes_;
  ByteReader raw_;
  uint32_t range_ = 0xffffffffU;
  uint32_t code_ = 0;
  uint32_t raw_word_ = 0;
  int kept_ = 0;
};

}  // namespace multitetra::shell
