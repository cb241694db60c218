// One-byte error codes: logarithmic, rounded up.
#pragma once

#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>

namespace multitetra {

// Code 0 is error 0. Code k from 1 to 254 is 2^((k - 1) / 16 - 6) voxels: sixteen codes an octave,
// starting at 1/64 voxel. Code 255 stands for all larger errors, without a bound.
class ErrorCodes {
 public:
  ErrorCodes() {
    // 2^(1/16) by square roots, which give the same bits on every machine.
    const double step = std::sqrt(std::sqrt(std::sqrt(std::sqrt(2.0))));
    values_[0] = 0;
    for (int octave = 0, code = 1; code < 255; ++octave) {
      double value = std::ldexp(1.0, octave - 6);
      for (int i = 0; i < 16 && code < 255; ++i, value *= step) {
        values_[static_cast<std::size_t>(code++)] = static_cast<float>(value);
      }
    }
    values_[255] = std::numeric_limits<float>::infinity();
    std::size_t code = 0;
    for (std::uint32_t high = 0; high < codes_.size(); ++high) {
      const auto value = std::bit_cast<float>(high << kDroppedBits);
      while (code < 255 && !(values_[code] >= value)) ++code;
      codes_[high] = static_cast<std::uint8_t>(code);
    }
  }

  // Returns the smallest code whose value is at least `error`, or the code above it. `error` is in
  // voxels, >= 0 and possibly infinite.
  [[nodiscard]] std::uint8_t code(float error) const {
    assert(error >= 0);
    const auto bits = std::bit_cast<std::uint32_t>(error);
    return codes_[(bits + (1U << kDroppedBits) - 1) >> kDroppedBits];
  }
  [[nodiscard]] float value(std::uint8_t code) const { return values_[code]; }  // In voxels.

 private:
  static constexpr int kDroppedBits = 16;
  std::array<float, 256> values_{};
  std::array<std::uint8_t, (0x7F800000U >> kDroppedBits) + 1> codes_{};
};

[[nodiscard]] inline const ErrorCodes& error_codes() {
  static const ErrorCodes codes;
  return codes;
}

}  // namespace multitetra
