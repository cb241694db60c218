#include "server/volume/formats/detail/half_floats.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace multitetra {
namespace {

class SlicesOfHalves : public StoredSlices {
 public:
  SlicesOfHalves(std::unique_ptr<StoredSlices> halves, const ImageHeader& header)
      : halves_(std::move(halves)), slice_bytes_(header.slice_bytes() / 2) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    buffer_.resize(slice_bytes_ * count);
    halves_->read(first, count, buffer_.data());
    const std::vector<std::byte> floats = floats_from_halves(buffer_);
    std::copy(floats.begin(), floats.end(), into);
  }

 private:
  std::unique_ptr<StoredSlices> halves_;
  std::size_t slice_bytes_;
  std::vector<std::byte> buffer_;
};

}  // namespace

float float_from_half(std::uint16_t half) {
  const int exponent = half >> 10 & 31;
  const int fraction = half & 1023;
  float size = 0;
  if (exponent == 31) {
    size = fraction == 0 ? std::numeric_limits<float>::infinity()
                         : std::numeric_limits<float>::quiet_NaN();
  } else if (exponent == 0) {
    size = std::ldexp(static_cast<float>(fraction), -24);
  } else {
    size = std::ldexp(static_cast<float>(fraction + 1024), exponent - 25);
  }
  return (half & 0x8000) != 0 ? -size : size;
}

std::vector<std::byte> floats_from_halves(std::span<const std::byte> halves) {
  static const std::vector<float> kFloats = [] {
    std::vector<float> all(65536);
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i] = float_from_half(static_cast<std::uint16_t>(i));
    }
    return all;
  }();
  std::vector<std::byte> floats(halves.size() * 2);
  for (std::size_t i = 0; i < halves.size() / 2; ++i) {
    std::uint16_t half = 0;
    std::memcpy(&half, halves.data() + 2 * i, sizeof(half));
    std::memcpy(floats.data() + 4 * i, &kFloats[half], sizeof(float));
  }
  return floats;
}

std::unique_ptr<StoredSlices> slices_of_halves(std::unique_ptr<StoredSlices> halves,
                                               const ImageHeader& header) {
  return std::make_unique<SlicesOfHalves>(std::move(halves), header);
}

}  // namespace multitetra
