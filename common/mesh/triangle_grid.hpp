// Which triangles of a mesh on the lattice are near to a box: a hash grid of several cell sizes.
//
// A triangle is filed once, under the cell that holds the low corner of its box, among the cells
// that are as large as the box at least. So what touches a box is filed in the cells that the box
// touches, or one before them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace multitetra {

// Closed, in lattice steps.
struct TriangleBox {
  LatticePoint low;
  LatticePoint high;

  [[nodiscard]] bool touches(const TriangleBox& o) const {
    return low.x <= o.high.x && o.low.x <= high.x && low.y <= o.high.y && o.low.y <= high.y &&
           low.z <= o.high.z && o.low.z <= high.z;
  }
};
[[nodiscard]] TriangleBox box_of(const LatticeTriangle& triangle);
[[nodiscard]] TriangleBox box_around(const TriangleBox& a, const TriangleBox& b);

class TriangleGrid {
 public:
  // For triangles with numbers below `count`. The smallest cells have 2^finest lattice steps a
  // side.
  TriangleGrid(std::size_t count, int finest);

  // Requires that it is not there.
  void insert(std::uint32_t triangle, const TriangleBox& box);
  // Requires that it is there.
  void remove(std::uint32_t triangle);

  // Calls visit(triangle) for those whose box touches `box`, until one returns true; whether one
  // did.
  template <typename Visit>
  bool visit_near(const TriangleBox& box, const Visit& visit) const {
    for (int level = 0; level < kLevels; ++level) {
      if (at_level_[static_cast<std::size_t>(level)] == 0) continue;
      const int shift = finest_ + 2 * level;
      for (std::int32_t z = (box.low.z >> shift) - 1; z <= box.high.z >> shift; ++z) {
        for (std::int32_t y = (box.low.y >> shift) - 1; y <= box.high.y >> shift; ++y) {
          for (std::int32_t x = (box.low.x >> shift) - 1; x <= box.high.x >> shift; ++x) {
            const Cell cell{x, y, z, level};
            for (std::uint32_t t = first_[slot(cell)]; t != kNone; t = filed_[t].next) {
              if (filed_[t].box.touches(box) && filed_[t].cell == cell && visit(t)) return true;
            }
          }
        }
      }
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  static constexpr int kLevels = kMaxLatticeBits + 1;

  struct Cell {
    std::int32_t x = 0, y = 0, z = 0, level = 0;

    friend bool operator==(const Cell&, const Cell&) = default;
  };
  struct Filed {
    TriangleBox box;
    Cell cell;
    std::uint32_t next = kNone, previous = kNone;
  };

  [[nodiscard]] std::size_t slot(const Cell& cell) const {
    const auto part = [](std::int32_t v, std::uint64_t factor) {
      return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v)) * factor;
    };
    const std::uint64_t mixed =
        part(cell.x, 0x9E3779B97F4A7C15U) + part(cell.y, 0xC2B2AE3D27D4EB4FU) +
        part(cell.z, 0x165667B19E3779F9U) + part(cell.level, 0xD6E8FEB86659FD93U);
    return static_cast<std::size_t>((mixed ^ mixed >> 32) * 0x9E3779B97F4A7C15U >> hash_shift_);
  }
  [[nodiscard]] Cell cell_of(const TriangleBox& box) const;

  int finest_;
  int hash_shift_;
  std::vector<std::uint32_t> first_;  // By slot.
  // By triangle.
  std::vector<Filed> filed_;
  std::array<std::size_t, kLevels> at_level_ = {};
};

}  // namespace multitetra
