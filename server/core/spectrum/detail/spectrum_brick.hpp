// A brick of a stored error spectrum: 512 dividing points, bin by bin, so that what one isovalue
// needs lies together.
//
//   u16 first bin | u16 bins n | u32 end[n] | plane of the first bin | plane of the next | ...
//
// end[i] is where plane i ends, in bytes after the last end. A plane is empty when no point has an
// error in its bin; otherwise it is
//
//   u64 mask[8]      bit p: point p has an error or a flip; m points do
//   u8 certified[m]  codes of error_codes.hpp, of these points in order
//   u8 paper[m]
//   u8 flips[m]      low half: 1 + log2 of the largest spacing of a flip, 0 without one; high half:
//                    of a critical flip
//
// A brick without any error has no bytes at all.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.hpp"
#include "server/core/spectrum/detail/error_curve.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {

// Collects the points of one brick and makes its bytes.
class SpectrumBrickBuilder {
 public:
  // Each point of the brick at most once, in any order. `voxel` is the unit of errors.
  void add(std::size_t point, const CurveBlock* blocks, CurveLayer::Curve curve, float voxel);
  // The bytes, and a fresh start.
  [[nodiscard]] std::vector<std::byte> take();

 private:
  struct Entry {
    std::uint16_t point;
    std::uint16_t first;  // Bin.
    std::uint16_t count;
    std::size_t offset;  // In codes_: three bytes a bin.
  };
  std::vector<Entry> entries_;
  std::vector<std::uint8_t> codes_;
};

// The decoded contents of one bin of a brick.
struct SpectrumPlane {
  struct Point {
    std::uint8_t certified = 0;  // Codes.
    std::uint8_t paper = 0;
    std::uint8_t flips = 0;
  };
  std::array<Point, SpectrumLayout::kPoints> points{};
};

// kDamagedData when the bytes are no brick.
[[nodiscard]] Result<SpectrumPlane> decode_plane(std::span<const std::byte> brick, int bin);

}  // namespace multitetra
