// Distances between two surfaces: the mean and the 99th percentile from points spread over it,
// the maximum between a distance that was found and one that no point exceeds.
//
// The maximum is searched for, not sampled. Distance to a triangle is a convex function, so the
// corners of a triangle bound what lies between them: no point of it is farther from the other
// surface than the farthest of its corners is from one and the same triangle there. Triangles whose
// bound is above what was found are cut in four, until the two agree within a tolerance or there
// would be too many of them; then the gap stays, and is reported.
#pragma once

#include <cstdint>
#include <optional>

#include "server/certify/triangle_mesh.hpp"

namespace multitetra {

struct DistanceSearch {
  std::uint64_t samples = 200'000;  // For mean and 99th percentile.
  // The tolerance of the maximum, in the unit of the coordinates.
  double tolerance = 0;
  // The search continues below the tolerance until it is decided whether a point is farther than
  // this.
  std::optional<double> limit = std::nullopt;
  std::size_t most_pieces = 400'000;  // Pieces that are cut further in each round.
};

// Lengths in the unit of the coordinates. All infinite where only the other surface is empty, all
// zero where this one is.
struct SurfaceDistance {
  // The largest distance of all measured points. The true maximum is not less.
  double maximum = 0;
  double maximum_at_most = 0;  // And not more than this.
  double percentile_99 = 0;
  double mean = 0;
  Vec3 farthest = {0, 0, 0};  // A point of this surface at the distance `maximum`.
  std::uint64_t samples = 0;  // Points that mean and percentile are of.
};

struct TwoSidedDistance {
  SurfaceDistance mesh_to_reference;
  SurfaceDistance reference_to_mesh;
};

// The same for any number of threads. Requires welded meshes or such as reference_surface makes.
[[nodiscard]] TwoSidedDistance two_sided_distance(const TriangleMesh& mesh,
                                                  const TriangleMesh& reference,
                                                  const DistanceSearch& search);

}  // namespace multitetra
