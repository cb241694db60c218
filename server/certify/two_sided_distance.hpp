// Distances between two surfaces: mean and 99th percentile over sampled points, and an interval
// that contains the maximum.
//
// The maximum is searched for, not sampled. The distance to a triangle is convex, so the corners of
// a triangle bound it: no point of it is farther from the other surface than the farthest of its
// corners is from any one triangle there. Triangles whose bound exceeds the largest measured
// distance are split into four until both agree within a tolerance, or too many pieces were split;
// then the remaining gap is reported.
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>

#include "common/mesh/triangle_mesh.hpp"
#include "server/certify/clipped_mesh.hpp"

namespace multitetra {

struct DistanceSearch {
  std::uint64_t samples = 200'000;  // For mean and 99th percentile.
  // Tolerance of the maximum, in the unit of the coordinates.
  double tolerance = 0;
  // Whether the maximum exceeds this is decided first, below the tolerance if necessary.
  std::optional<double> limit = std::nullopt;
  // Maximum number of pieces that are split at once; forty times as many are split in all.
  std::size_t max_pieces = 400'000;
  std::stop_token stop = {};
};

// Lengths in the unit of the coordinates. All infinite if only the other surface is empty; all zero
// if this one is.
struct SurfaceDistance {
  // The largest measured distance: a lower bound of the true maximum.
  double maximum = 0;
  double maximum_at_most = 0;  // Upper bound of the true maximum.
  // Pieces that the search had no memory or time for: with them `maximum_at_most` may be far from
  // `maximum`.
  std::uint64_t undecided = 0;
  double percentile_99 = 0;
  double mean = 0;
  Vec3 farthest = {0, 0, 0};  // The point of this surface at the distance `maximum`.
  std::uint64_t samples = 0;  // Number of points for mean and percentile.
};

struct TwoSidedDistance {
  SurfaceDistance mesh_to_reference;
  SurfaceDistance reference_to_mesh;
};

// Returns the same result for any number of threads. Throws Cancelled soon after the search's
// `stop` is triggered. Requires welded meshes, or ones from reference_surface(). With `within`,
// measures only the parts of both surfaces inside the box, from the whole other surface; both
// distances are 0, with no samples, if there are none.
[[nodiscard]] TwoSidedDistance two_sided_distance(const TriangleMesh& mesh,
                                                  const TriangleMesh& reference,
                                                  const DistanceSearch& search,
                                                  const std::optional<PlacedBox>& within = {});

}  // namespace multitetra
