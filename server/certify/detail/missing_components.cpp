#include "server/certify/detail/missing_components.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <oneapi/tbb/parallel_for.h>

namespace multitetra {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The distances of a component's vertices from the mesh, and its diagonal.
struct ComponentDistance {
  double nearest = kInfinity;
  double farthest = 0;
  double diagonal = 0;
};

std::vector<ComponentDistance> distances_of_components(const ReferenceSurface& reference,
                                                       const TriangleMesh& mesh) {
  const NearestTriangle nearest(triangles_of(mesh));
  std::vector<double> distances(reference.mesh.vertices.size());
  tbb::parallel_for(std::size_t{0}, distances.size(), [&](std::size_t i) {
    distances[i] = nearest.distance(reference.mesh.vertices[i]);
  });
  std::vector<ComponentDistance> components(reference.components.diagonals.size());
  for (std::size_t i = 0; i < components.size(); ++i) {
    components[i].diagonal = reference.components.diagonals[i];
  }
  for (std::size_t v = 0; v < distances.size(); ++v) {
    ComponentDistance& of = components[reference.components.of_vertex[v]];
    of.nearest = std::min(of.nearest, distances[v]);
    of.farthest = std::max(of.farthest, distances[v]);
  }
  return components;
}

// A number above `diagonal` and not above `most`, with as few digits as possible.
double just_above(double diagonal, double most) {
  for (double factor = 1; factor <= 1e6; factor *= 10) {
    const double rounded = (std::floor(diagonal * factor) + 1) / factor;
    if (rounded <= most) return rounded;
  }
  return most;
}

}  // namespace

ExpectedComponents::ExpectedComponents(const TriangleMesh& mesh, double min_component,
                                       double allowed, double voxel)
    : nearest_(triangles_of(mesh)),
      least_(min_component - 4 * allowed / voxel),
      most_(min_component + 4 * allowed / voxel),
      allowed_(allowed) {}

bool ExpectedComponents::contain(double diagonal, const Vec3& vertex) const {
  if (diagonal < least_ || diagonal >= most_) return diagonal >= most_;
  return nearest_.distance(vertex) <= allowed_;
}

std::optional<MissingComponents> missing_components(const ReferenceSurface& reference,
                                                    const TriangleMesh& mesh, double allowed) {
  MissingComponents missing;
  double least_present = kInfinity;
  for (const ComponentDistance& component : distances_of_components(reference, mesh)) {
    if (component.nearest > allowed) {
      ++missing.count;
      missing.largest_diagonal = std::max(missing.largest_diagonal, component.diagonal);
    } else if (component.farthest > allowed) {
      return std::nullopt;
    } else {
      least_present = std::min(least_present, component.diagonal);
    }
  }
  if (missing.count == 0 || std::isinf(least_present)) return std::nullopt;
  if (missing.largest_diagonal < least_present) {
    missing.min_component = just_above(missing.largest_diagonal, least_present);
  }
  return missing;
}

}  // namespace multitetra
