// A brick of a stored error spectrum: 512 dividing points, stored bin by bin, so that the data for
// one isovalue is contiguous.
//
//   u16 first bin | u16 bins n | u32 end[n] | plane of the first bin | plane of the next | ...
//
// end[i] is the end of plane i, in bytes after the last end. A plane is empty if no point has an
// error in its bin; otherwise it is
//
//   u64 mask[8]      bit p: point p has an error or a flip; m points do
//   u8 certified[m]  codes of error_codes.hpp, of these points in order
//   u8 paper[m]
//   u8 flips[m]      low half: 1 + log2 of the largest spacing of a flip, 0 without one; high half:
//                    of a critical flip
//
// A brick without errors has no bytes.
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

// Collects the points of one brick and encodes them.
class SpectrumBrickBuilder {
 public:
  // Adds a point of the brick, each at most once, in any order. `voxel` is the unit of errors.
  void add(std::size_t point, const CurveBlock* blocks, CurveLayer::Curve curve, float voxel);
  // Returns the encoded brick and resets the builder.
  [[nodiscard]] std::vector<std::byte> take();

 private:
  struct Entry {
    std::uint16_t point;
    std::uint16_t first;  // The first bin.
    std::uint16_t count;
    std::size_t offset;  // Index in codes_, which has three bytes a bin.
  };
  std::vector<Entry> entries_;
  std::vector<std::uint8_t> codes_;
};

// One decoded bin of a brick.
struct SpectrumPlane {
  struct Point {
    std::uint8_t certified = 0;  // Error codes.
    std::uint8_t paper = 0;
    std::uint8_t flips = 0;
  };
  std::array<Point, SpectrumLayout::kPoints> points{};
};

// Fails with kDamagedData if the bytes are not a valid brick.
[[nodiscard]] Result<SpectrumPlane> decode_plane(std::span<const std::byte> brick, int bin);

}  // namespace multitetra
