// Assigns indices to lattice points in order of appearance, so that triangles share vertices.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/mesh/lattice.hpp"

namespace multitetra {

// A hash table with linear probing, at most half full; the caller stores the points. Requires
// lattice coordinates within 0 .. 2^kMaxLatticeBits.
class VertexNumbers {
 public:
  explicit VertexNumbers(std::size_t expected_vertices = 0) { reserve(expected_vertices); }

  // Returns the index of the point in `vertices`, appending it if it is new. Does not find points
  // that the caller appended itself.
  std::uint32_t number(const LatticePoint& point, std::vector<LatticePoint>& vertices) {
    if (2 * (known_.size() + 1) > slots_.size()) grow(vertices);
    std::uint32_t& slot = find(point, vertices);
    if (slot == kFree) {
      slot = static_cast<std::uint32_t>(vertices.size());
      known_.push_back(slot);
      vertices.push_back(point);
    }
    return slot;
  }

 private:
  static constexpr std::uint32_t kFree = std::numeric_limits<std::uint32_t>::max();

  void reserve(std::size_t vertices) {
    slots_.assign(std::bit_ceil(2 * vertices + 16), kFree);
    shift_ = 64 - std::countr_zero(slots_.size());
  }
  void grow(const std::vector<LatticePoint>& vertices) {
    reserve(slots_.size());
    for (const std::uint32_t i : known_) find(vertices[i], vertices) = i;
  }
  std::uint32_t& find(const LatticePoint& point, const std::vector<LatticePoint>& vertices) {
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = static_cast<std::size_t>((point.key() * 0x9E3779B97F4A7C15u) >> shift_);
    while (slots_[at] != kFree && vertices[slots_[at]] != point) at = (at + 1) & mask;
    return slots_[at];
  }

  std::vector<std::uint32_t> slots_;
  std::vector<std::uint32_t> known_;
  int shift_ = 0;
};

}  // namespace multitetra
