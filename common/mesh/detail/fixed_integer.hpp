// Two's complement integers with a fixed number of 64-bit limbs. Overflow wraps around unchecked.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace multitetra {

template <std::size_t limbs>
class FixedInteger {
 public:
  FixedInteger() = default;
  explicit FixedInteger(std::int64_t value) {
    limbs_.fill(value < 0 ? ~std::uint64_t{0} : 0);
    limbs_[0] = static_cast<std::uint64_t>(value);
  }

  [[nodiscard]] int sign() const {
    if (limbs_.back() >> 63 != 0) return -1;
    for (const std::uint64_t limb : limbs_) {
      if (limb != 0) return 1;
    }
    return 0;
  }

  // Returns the value times 2^bits; requires bits >= 0.
  [[nodiscard]] FixedInteger shifted(int bits) const {
    const auto whole = static_cast<std::size_t>(bits) / 64;
    const int rest = bits % 64;
    FixedInteger result;
    for (std::size_t i = whole; i < limbs; ++i) {
      result.limbs_[i] = limbs_[i - whole] << rest;
      if (rest != 0 && i > whole) result.limbs_[i] |= limbs_[i - whole - 1] >> (64 - rest);
    }
    return result;
  }

  friend FixedInteger operator+(const FixedInteger& a, const FixedInteger& b) {
    return added(a, b, 0, 0);
  }
  // Computes a + not b + 1.
  friend FixedInteger operator-(const FixedInteger& a, const FixedInteger& b) {
    return added(a, b, ~std::uint64_t{0}, 1);
  }
  friend FixedInteger operator*(const FixedInteger& a, const FixedInteger& b) {
    FixedInteger product;
    for (std::size_t i = 0; i < limbs; ++i) {
      std::uint64_t carry = 0;
      for (std::size_t j = 0; i + j < limbs; ++j) {
        const Wide sum = Wide{a.limbs_[i]} * b.limbs_[j] + product.limbs_[i + j] + carry;
        product.limbs_[i + j] = static_cast<std::uint64_t>(sum);
        carry = static_cast<std::uint64_t>(sum >> 64);
      }
    }
    return product;
  }

 private:
  __extension__ using Wide = unsigned __int128;

  static FixedInteger added(const FixedInteger& a, const FixedInteger& b, std::uint64_t flips,
                            std::uint64_t carry) {
    FixedInteger sum;
    for (std::size_t i = 0; i < limbs; ++i) {
      const Wide both = Wide{a.limbs_[i]} + (b.limbs_[i] ^ flips) + carry;
      sum.limbs_[i] = static_cast<std::uint64_t>(both);
      carry = static_cast<std::uint64_t>(both >> 64);
    }
    return sum;
  }

  std::array<std::uint64_t, limbs> limbs_{};
};

}  // namespace multitetra
