// The regions of a threshold map, ready to be compared with boxes of the grid.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/request/local_thresholds.hpp"
#include "server/core/framework/box.hpp"

namespace multitetra {

// The relation of a region to a box. As computed, a box inside one that a region contains is
// contained too, and a box around one that a region touches is touched too. A region that is
// reported to touch may miss the box where their axes are not parallel; one that is reported to
// contain does.
enum class Contact { kApart, kTouches, kContains };

class RegionSet {
 public:
  using Index = std::uint32_t;

  // `to_regions` maps grid coordinates to those of the regions; `unit` is the length of 1 in the
  // thresholds' unit. With Combination::kMinimum the regions are sorted, so that the last that
  // contains a place has the least threshold.
  RegionSet(std::span<const ThresholdRegion> regions, Combination combination,
            const Affine& to_regions, double unit);

  [[nodiscard]] Index size() const { return static_cast<Index>(regions_.size()); }
  [[nodiscard]] double threshold(Index i) const { return regions_[i].threshold; }  // World units.

  // A box in grid coordinates with its image in those of the regions.
  struct Places {
    Box grid;
    Box image;
  };
  [[nodiscard]] Places places(const Box& box) const { return {box, image_of(to_regions_, box)}; }
  [[nodiscard]] Contact contact(Index i, const Places& places) const;

  // Regions that may hold somewhere in a box: those that touch it, the last first, up to and
  // including the first of them that contains it and so hides all before.
  struct List {
    std::vector<Index> regions;
    bool is_closed = false;  // The last entry contains the box.
  };
  [[nodiscard]] List all() const;
  // The part of a box's list that concerns a box inside it.
  [[nodiscard]] List relevant(const List& of_outer, const Box& box) const;

 private:
  enum class Kind : std::uint8_t { kBox, kBall, kHalfSpace };
  struct Region {
    Kind kind;
    double threshold;
    Box box;        // kBox, in the regions' coordinates.
    Vec3 vector;    // kBall: centre in the regions' coordinates; kHalfSpace: normal in the grid's.
    double number;  // kBall: squared radius; kHalfSpace: offset in the grid's coordinates.
  };
  [[nodiscard]] Region prepared(const ThresholdRegion& region, double unit) const;

  Affine to_regions_;
  std::vector<Region> regions_;
};

}  // namespace multitetra
