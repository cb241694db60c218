// The counterpart of RangeDecoder.
#pragma once

#include <cstdint>
#include <vector>

#include "common/codec/detail/range_coder.hpp"

namespace multitetra::shell {

class RangeEncoder {
 public:
  static constexpr bool kEncodes = true;

  bool bit(Probability& p, bool one) {
    const std::uint32_t bound = (range_ >> 15) * p.of_one();
    if (one) {
      range_ = bound;
      p.learn_one();
    } else {
      low_ += bound;
      range_ -= bound;
      p.learn_zero();
    }
    while (range_ < kMinRange) {
      range_ <<= 8;
      shift();
    }
    return one;
  }

  // Requires that only the lowest `count` (1 to 25) of `bits` are set.
  std::uint32_t raw_bits(int count, std::uint32_t bits) {
    raw_word_ |= bits << kept_;
    kept_ += count;
    while (kept_ >= 8) {
      raw_.push_back(static_cast<std::uint8_t>(raw_word_));
      raw_word_ >>= 8;
      kept_ -= 8;
    }
    return bits;
  }

  // Completes both streams. Call once.
  void finish() {
    // Selects the number in the interval with the most trailing zero bytes.
    const std::uint64_t last = low_ + range_ - 1;
    const auto rounded = [last](int bytes) { return last >> (8 * bytes) << (8 * bytes); };
    int zeros = 0;
    while (zeros < 4 && rounded(zeros + 1) >= low_) ++zeros;
    low_ = rounded(zeros);
    for (int i = 0; i < 5; ++i) shift();
    for (std::uint32_t i = 0;
         i < RangeDecoder::kMaxMissing && !bytes_.empty() && bytes_.back() == 0; ++i) {
      bytes_.pop_back();
    }
    if (kept_ > 0) raw_.push_back(static_cast<std::uint8_t>(raw_word_));
  }

  [[nodiscard]] const std::vector<std::uint8_t>& bytes() const { return bytes_; }
  [[nodiscard]] const std::vector<std::uint8_t>& raw() const { return raw_; }

 private:
  // Outputs the highest byte of `low_`. A byte, and all 255s after it, are held back until no carry
  // can reach them.
  void shift() {
    if (low_ < 0xff000000U || low_ > 0xffffffffU) {
      const auto carry = static_cast<std::uint8_t>(low_ >> 32);
      if (has_kept_) bytes_.push_back(static_cast<std::uint8_t>(kept_byte_ + carry));
      for (; full_bytes_ > 0; --full_bytes_) {
        bytes_.push_back(static_cast<std::uint8_t>(0xff + carry));
      }
      kept_byte_ = static_cast<std::uint8_t>(low_ >> 24);
      has_kept_ = true;
    } else {
      ++full_bytes_;
    }
    low_ = (low_ & 0x00ffffffU) << 8;
  }

  std::vector<std::uint8_t> bytes_;
  std::vector<std::uint8_t> raw_;
  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xffffffffU;
  std::uint8_t kept_byte_ = 0;
  bool has_kept_ = false;
  std::uint64_t full_bytes_ = 0;
  std::uint32_t raw_word_ = 0;
  int kept_ = 0;
};

}  // namespace multitetra::shell
