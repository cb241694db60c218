#include "server/volume/formats/detail/half_floats.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
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
  // The exponents of halves are biased by 15, those of floats by 127.
  const std::uint32_t bits = (half & 0x7FFFU) << 13;
  const bool is_finite = (half & 0x7C00U) != 0x7C00U;
  const float size =
      is_finite ? std::bit_cast<float>(bits) * 0x1p112F : std::bit_cast<float>(bits | 0x7F800000U);
  return (half & 0x8000U) != 0 ? -size : size;
}

std::vector<std::byte> floats_from_halves(std::span<const std::byte> halves) {
  std::vector<std::byte> floats(halves.size() * 2);
  for (std::size_t i = 0; i < halves.size() / 2; ++i) {
    std::uint16_t half = 0;
    std::memcpy(&half, halves.data() + 2 * i, sizeof(half));
    const float number = float_from_half(half);
    std::memcpy(floats.data() + 4 * i, &number, sizeof(number));
  }
  return floats;
}

std::unique_ptr<StoredSlices> slices_of_halves(std::unique_ptr<StoredSlices> halves,
                                               const ImageHeader& header) {
  return std::make_unique<SlicesOfHalves>(std::move(halves), header);
}

}  // namespace multitetra
