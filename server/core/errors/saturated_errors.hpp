// The exact errors of all dividing points for one isovalue, each at least as large as those of its
// descendants (Zhou, Chen and Kaufman 1997, section 4). The reference for faster methods.
//
// Errors are propagated from points to their parents in the order of spacing 1, 2, 4, ..., and
// within a spacing edge, face, cube, so that children are complete before their parents:
//
//   paper      E(p) = max(own error, E of the children)
//   certified  E(p) = certified own error + max(E of the children)
//
// The certified error bounds the two-sided Hausdorff distance between the mesh and the
// full-resolution isosurface. Within a phase in which no sign changes, every surface point in a
// tetrahedron moves at most as far as the crossings on its edges; the displacements of phases, and
// of fusions along a chain, add up.
#pragma once

#include <cstdint>
#include <vector>

#include "common/request/isosurface_request.hpp"
#include "server/core/framework/dividing_point.hpp"
#include "server/core/framework/field.hpp"
#include "server/core/framework/for_each.hpp"
#include "server/core/framework/level_extent.hpp"

namespace multitetra {

// Bounds for a dividing point and all its descendants.
struct ErrorBound {
  float error = 0;  // World units.
  // The largest spacing of a flip that the topology rule forbids, or 0.
  std::int32_t flip_spacing = 0;
};

class SaturatedErrors {
 public:
  // Takes one pass over the field: O(samples) time and 5 bytes a sample. The result does not depend
  // on `for_each`. Points of a spacing below `finest_spacing` get no error.
  SaturatedErrors(const Field& field, double isovalue, ErrorMeasure measure, TopologyRule rule,
                  const ForEach& for_each = sequentially, std::int32_t finest_spacing = 1);

  // Returns the errors rounded up to float, so never less than the exact value.
  [[nodiscard]] ErrorBound bound(const DividingPoint& point) const;

 private:
  struct Level {
    LevelExtent extent;
    std::vector<float> error;
    std::vector<std::uint8_t> flip;  // 0, or 1 + log2 of the spacing.

    [[nodiscard]] ErrorBound bound(std::size_t index) const {
      return {error[index], (1 << flip[index]) >> 1};
    }
  };
  [[nodiscard]] static Level level_for(const Field& field, int exponent);

  template <typename Sample>
  class Pass;

  // Level e holds the points with spacing 2^e.
  std::vector<Level> levels_;
};

}  // namespace multitetra
