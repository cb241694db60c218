// Errors of dividing points as functions of the isovalue, one value per bin.
//
// A curve covers a range of bins; elsewhere it is 0. Bins are stored in blocks of four that begin
// at multiples of four, so that the curves of a point and of its children are aligned.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/core/framework/diamond_values.hpp"

namespace multitetra {

using Float4 = float __attribute__((vector_size(16)));
using Byte8 = std::uint8_t __attribute__((vector_size(8)));

// Upper bounds for a point and all its descendants, for each of four bins.
struct CurveBlock {
  Float4 paper{};      // The paper's error in world units.
  Float4 certified{};  // The certified error in world units.
  // [i]: 1 + log2 of the largest spacing of a flip in bin i, or 0; [4 + i]: of a critical flip.
  Byte8 flips{};
};

// The curves of a layer of points with the same z. Its memory is reused for the next layer.
class CurveLayer {
 public:
  struct Curve {
    std::uint32_t offset = 0;  // Index of the first block.
    // The first bin is 4 * first.
    std::uint16_t first = 0;
    std::uint16_t count = 0;  // Number of blocks; 0 without errors.
  };

  // Removes all curves. `low` and `extent` are in the level's units; z is ignored.
  void reset(GridPoint low, GridPoint extent) {
    low_ = low;
    extent_ = extent;
    curves_.assign(static_cast<std::size_t>(extent.x + 2) * static_cast<std::size_t>(extent.y + 2),
                   {});
    used_ = 0;
  }

  [[nodiscard]] bool contains(std::int32_t x, std::int32_t y) const {
    return x >= low_.x && y >= low_.y && x < low_.x + extent_.x && y < low_.y + extent_.y;
  }
  // Requires contains(x, y). Reading is allowed one step beyond, where curves are empty.
  [[nodiscard]] Curve& at(std::int32_t x, std::int32_t y) { return curves_[index(x, y)]; }
  [[nodiscard]] Curve at(std::int32_t x, std::int32_t y) const { return curves_[index(x, y)]; }
  // Returns the curve of any point; it is empty outside of the layer.
  [[nodiscard]] Curve find(std::int32_t x, std::int32_t y) const {
    return contains(x, y) ? at(x, y) : Curve{};
  }
  [[nodiscard]] const CurveBlock* blocks(Curve curve) const { return pool_.data() + curve.offset; }

  // Appends uninitialized blocks for a curve. Invalidates pointers to earlier blocks.
  [[nodiscard]] CurveBlock* append(std::size_t count, std::uint32_t& offset) {
    if (used_ + count > pool_.size())
      pool_.resize(std::max(pool_.size() + pool_.size() / 4, used_ + count));
    offset = static_cast<std::uint32_t>(used_);
    used_ += count;
    return pool_.data() + offset;
  }
  [[nodiscard]] GridPoint low() const { return low_; }
  [[nodiscard]] GridPoint extent() const { return extent_; }

 private:
  [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(x - low_.x + 1) +
           static_cast<std::size_t>(extent_.x + 2) * static_cast<std::size_t>(y - low_.y + 1);
  }

  GridPoint low_;
  GridPoint extent_;
  // Includes an empty border of one place.
  std::vector<Curve> curves_;
  std::vector<CurveBlock> pool_;
  std::size_t used_ = 0;
};

}  // namespace multitetra
