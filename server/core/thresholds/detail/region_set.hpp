// The regions of a threshold map, prepared for comparison with boxes of the grid.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/request/local_thresholds.hpp"
#include "server/core/framework/box.hpp"

namespace multitetra {

// The relation of a region to a box, monotone as computed: a region that contains a box contains
// every box inside it, and one that touches a box touches every box around it. If axes are not
// parallel, kTouches may be reported for a region that misses the box; kContains is exact.
enum class Contact { kDisjoint, kTouches, kContains };

class RegionSet {
 public:
  using Index = std::uint32_t;

  // `to_regions` maps grid coordinates to those of the regions; `unit` is the world length of the
  // thresholds' unit. With Combination::kMinimum the regions are sorted, so that the last one that
  // contains a place has the least threshold.
  RegionSet(std::span<const ThresholdRegion> regions, Combination combination,
            const Affine& to_regions, double unit);

  [[nodiscard]] Index size() const { return static_cast<Index>(regions_.size()); }
  [[nodiscard]] double threshold(Index i) const { return regions_[i].threshold; }  // World units.

  // A box in grid coordinates, and its image in the regions' coordinates.
  struct MappedBox {
    Box grid;
    Box image;
  };
  [[nodiscard]] MappedBox mapped(const Box& box) const { return {box, image_of(to_regions_, box)}; }
  [[nodiscard]] Contact contact(Index i, const MappedBox& places) const;

  // The regions that may apply in a box: those that touch it, the last first, up to the first that
  // contains the box and so hides all earlier regions.
  struct List {
    std::vector<Index> regions;
    // The last entry contains the box.
    bool is_closed = false;
  };
  [[nodiscard]] List all() const;
  // Returns the part of a box's list that applies to a box inside it.
  [[nodiscard]] List relevant(const List& of_outer, const Box& box) const;

 private:
  enum class Kind : std::uint8_t { kBox, kBall, kHalfSpace };
  struct Region {
    Kind kind;
    double threshold;
    Box box;        // kBox, in the regions' coordinates.
    Vec3 vector;    // kBall: center in the regions' coordinates; kHalfSpace: normal in the grid's.
    double number;  // kBall: squared radius; kHalfSpace: offset in the grid's coordinates.
  };
  [[nodiscard]] Region prepared(const ThresholdRegion& region, double unit) const;

  Affine to_regions_;
  std::vector<Region> regions_;
};

}  // namespace multitetra
