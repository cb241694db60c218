#include "client/distance_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "client/full_resolution_surface.hpp"

namespace multitetra {
namespace {

// For what double arithmetic on world coordinates loses.
constexpr double kRounding = 1e-9;  // Voxels.

// From the request, not from what the server makes of it; only where thresholds differ from place
// to place the largest of them is taken as the server tells it.
double threshold_world(const StepBegin& begin, const DatasetInfo& info) {
  const IsosurfaceRequest& request = begin.request;
  if (!request.thresholds.is_uniform()) return begin.error_bound_world;
  const double unit = request.unit == LengthUnit::kVoxel ? voxel_length(info) : 1.0;
  return unit * std::max(request.error, request.thresholds.at_least);
}

bool bounds_distances(const StepBegin& begin) {
  return begin.request.measure == ErrorMeasure::kCertified && preserves_topology(begin);
}

std::vector<SurfaceTriangle> in_world(const LatticeMesh& mesh, const DatasetInfo& info) {
  const Affine to_world = grid_to_world(info);
  std::vector<Vec3> places;
  places.reserve(mesh.vertices.size());
  for (const LatticePoint& vertex : mesh.vertices) {
    places.push_back(to_world(grid_coordinates(vertex, mesh.resolution)));
  }
  std::vector<SurfaceTriangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const TriangleIndices& t : mesh.triangles) {
    triangles.push_back({places[t[0]], places[t[1]], places[t[2]]});
  }
  return triangles;
}

DistanceStatistics in_voxels(DistanceStatistics world, double voxel) {
  for (double* length : {&world.maximum, &world.percentile_99, &world.mean, &world.worst_distance,
                         &world.worst_limit}) {
    *length /= voxel;
  }
  return world;
}

}  // namespace

double snapping_world(const DatasetInfo& info, int lattice_resolution) {
  const auto& columns = grid_to_world(info).columns;
  double longest = 0;
  for (int signs = 0; signs < 4; ++signs) {
    const double y = (signs & 1) != 0 ? 1 : -1;
    const double z = (signs & 2) != 0 ? 1 : -1;
    double squared = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      const double sum = columns[0][row] + y * columns[1][row] + z * columns[2][row];
      squared += sum * sum;
    }
    longest = std::max(longest, std::sqrt(squared));
  }
  return longest / static_cast<double>(1 << lattice_resolution);
}

std::optional<DistanceLimit> promised_limit(const StepBegin& begin, const DatasetInfo& info) {
  if (!bounds_distances(begin)) return std::nullopt;
  const double limit = threshold_world(begin, info) +
                       snapping_world(info, begin.request.lattice_resolution) +
                       kRounding * voxel_length(info);
  return DistanceLimit([limit](const Vec3&) { return limit; });
}

DistanceCheck check_distances(const CommittedStep& step, const DatasetInfo& info,
                              std::span<const float> samples, const DistanceCheckOptions& options) {
  const StepBegin& begin = step.begin;
  const double voxel = voxel_length(info);
  DistanceCheck check;
  const auto promised = promised_limit(begin, info);
  if (promised) {
    check.promise = {.threshold = threshold_world(begin, info) / voxel,
                     .snapping = snapping_world(info, begin.request.lattice_resolution) / voxel};
  }
  const DistanceLimit limit =
      promised ? *promised
               : DistanceLimit([](const Vec3&) { return std::numeric_limits<double>::infinity(); });
  auto mesh = in_world(step.mesh, info);
  auto full = full_resolution_surface(info, samples, begin.request.isovalue);
  check.full_triangles = full.size();
  const auto points_of_mesh = sampled_points(mesh, options.samples, options.seed);
  const auto points_of_full = sampled_points(full, options.samples, options.seed);
  check.mesh_to_full =
      in_voxels(distances(points_of_mesh, NearestTriangle(std::move(full)), limit), voxel);
  check.full_to_mesh =
      in_voxels(distances(points_of_full, NearestTriangle(std::move(mesh)), limit), voxel);
  return check;
}

}  // namespace multitetra
