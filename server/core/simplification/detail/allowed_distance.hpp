// The displacement that simplification may cause: uniform, or a share of a threshold map.
#pragma once

#include <algorithm>
#include <span>
#include <utility>

#include "common/base/vec3.hpp"
#include "common/mesh/lattice.hpp"
#include "server/core/framework/box.hpp"
#include "server/core/thresholds/threshold_map.hpp"

namespace multitetra {

class AllowedDistance {
 public:
  // The same distance everywhere, finite and >= 0. Implicit, so that a number is a limit.
  AllowedDistance(double everywhere = 0) : thresholds_(ThresholdMap::everywhere(everywhere)) {}
  // `share` of the thresholds, above 0 and at most 1. The rest is the model's: the simplified
  // surface may already be that far from the surface that the thresholds refer to.
  AllowedDistance(ThresholdMap thresholds, double share)
      : thresholds_(std::move(thresholds)), share_(share) {}

  [[nodiscard]] double largest() const { return share_ * thresholds_.largest(); }
  // Returns a lower bound of the limits in a box of grid steps.
  [[nodiscard]] double least_in(const Box& box) const { return share_ * thresholds_.least_in(box); }
  // Returns the displacement allowed to the model for each unit allowed to simplification.
  [[nodiscard]] double model_per_simplification() const { return (1 - share_) / share_; }

 private:
  ThresholdMap thresholds_;
  double share_ = 1;
};

// The coordinate frame in which a piece is simplified: relative to one of its vertices, in units of
// the shortest lattice step.
struct PieceFrame {
  double unit = 1;  // Length of that step.
  // Lengths of a lattice step along each axis, in units.
  Vec3 proportions = {1, 1, 1};
  // Keeps coordinates small and so precise.
  LatticePoint origin = {};
  double lattice_per_voxel = 32;  // Lattice steps per grid step.

  [[nodiscard]] Vec3 position(const LatticePoint& p) const {
    return {proportions[0] * (p.x - origin.x), proportions[1] * (p.y - origin.y),
            proportions[2] * (p.z - origin.z)};
  }
  // Returns a box of grid steps that contains all points within `reach` units of a box of
  // positions, before they are snapped to the lattice.
  [[nodiscard]] Box grid_box(const Box& box, double reach) const;
};

[[nodiscard]] inline Box box_around(const Vec3& position) { return {position, position}; }
inline void include(Box& box, const Vec3& position) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.low[axis] = std::min(box.low[axis], position[axis]);
    box.high[axis] = std::max(box.high[axis], position[axis]);
  }
}
[[nodiscard]] inline Box box_of(std::span<const Vec3> positions) {
  Box box = box_around(positions.front());
  for (const Vec3& position : positions) include(box, position);
  return box;
}

// A limit for one piece; positions and lengths are in its frame.
class PieceLimit {
 public:
  // Requires at least one position.
  PieceLimit(const AllowedDistance& limit, const PieceFrame& frame,
             std::span<const Vec3> positions);

  // Returns whether the limit is `largest` in the whole piece.
  [[nodiscard]] bool is_uniform() const { return is_uniform_; }
  [[nodiscard]] double largest() const { return largest_; }
  // Returns a lower bound of the limits within `reach` of the box, extended by the distance that
  // the model may have moved points which simplification moves by `distance`.
  [[nodiscard]] double least_near(const Box& box, double reach, double distance) const;
  // Converts a length to grid steps of the shortest axis.
  [[nodiscard]] double in_voxels(double length) const { return length / frame_.lattice_per_voxel; }

 private:
  AllowedDistance limit_;
  PieceFrame frame_;
  double largest_;
  bool is_uniform_;
};

}  // namespace multitetra
