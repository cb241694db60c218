#include "server/certify/detail/missing_components.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/in_parallel.hpp"

namespace multitetra {
namespace {

// The number of vertices of a component within and beyond the allowed distance of the mesh, and the
// diagonal of the component.
struct ComponentFit {
  std::size_t near = 0;
  std::size_t far = 0;
  double diagonal = 0;
};

std::vector<ComponentFit> fits_of_components(const ReferenceSurface& reference,
                                             const TriangleMesh& mesh, double allowed) {
  const NearestTriangle nearest(triangles_of(mesh));
  std::vector<char> is_near(reference.mesh.vertices.size());
  in_parallel(is_near.size(), [&](std::size_t i) {
    is_near[i] = nearest.distance(reference.mesh.vertices[i]) <= allowed ? 1 : 0;
  });
  std::vector<ComponentFit> components(reference.components.diagonals.size());
  for (std::size_t i = 0; i < components.size(); ++i) {
    components[i].diagonal = reference.components.diagonals[i];
  }
  for (std::size_t v = 0; v < is_near.size(); ++v) {
    ComponentFit& of = components[reference.components.of_vertex[v]];
    ++(is_near[v] != 0 ? of.near : of.far);
  }
  return components;
}

// Returns the triangles of components with a shorter diagonal.
TriangleMesh components_below(const TriangleMesh& mesh, const MeshComponents& components,
                              double diagonal) {
  TriangleMesh small{.vertices = mesh.vertices, .triangles = {}};
  for (const TriangleIndices& t : mesh.triangles) {
    if (components.diagonals[components.of_vertex[t[0]]] < diagonal) small.triangles.push_back(t);
  }
  return small;
}

// Returns a number above `diagonal` and at most `max_diagonal`, with as few digits as possible.
double just_above(double diagonal, double max_diagonal) {
  for (double factor = 1; factor <= 1e6; factor *= 10) {
    const double rounded = (std::floor(diagonal * factor) + 1) / factor;
    if (rounded <= max_diagonal) return rounded;
  }
  return max_diagonal;
}

}  // namespace

MeshComponents components_of(const TriangleMesh& mesh, const Affine& world_to_grid) {
  constexpr int kResolution = 8;            // Diagonals are exact to 1/256 of a grid step.
  constexpr double kMaxLatticeSteps = 1e8;  // In lattice steps: beyond any grid.
  const auto coordinate = [&](double steps) {
    return static_cast<std::int32_t>(std::lround(
        std::clamp(std::ldexp(steps, kResolution), -kMaxLatticeSteps, kMaxLatticeSteps)));
  };
  LatticeMesh lattice{.resolution = kResolution, .vertices = {}, .triangles = mesh.triangles};
  lattice.vertices.reserve(mesh.vertices.size());
  for (const Vec3& vertex : mesh.vertices) {
    const Vec3 at = world_to_grid(vertex);
    lattice.vertices.push_back({coordinate(at[0]), coordinate(at[1]), coordinate(at[2])});
  }
  return components_of(lattice);
}

std::vector<char> ExpectedComponents::operator()(const std::vector<Vec3>& vertices,
                                                 const MeshComponents& all) const {
  const double slack = 4 * allowed / voxel;
  std::vector<char> stays(all.diagonals.size(), 0);
  std::vector<std::uint32_t> uncertain;
  std::size_t longer = 0;
  for (std::uint32_t i = 0; i < stays.size(); ++i) {
    const double diagonal = all.diagonals[i];
    stays[i] = diagonal >= min_component + slack ? 1 : 0;
    if (stays[i] != 0) ++longer;
    if (std::abs(diagonal - min_component) < slack) uncertain.push_back(i);
  }
  const std::size_t others =
      components.diagonals.size() - std::min(longer, components.diagonals.size());
  const std::vector<char> is_absent = absent(vertices, all, min_component + 2 * slack);
  std::erase_if(uncertain, [&](std::uint32_t i) { return is_absent[i] != 0; });
  std::stable_sort(uncertain.begin(), uncertain.end(), [&](std::uint32_t a, std::uint32_t b) {
    return all.diagonals[a] > all.diagonals[b];
  });
  uncertain.resize(std::min(uncertain.size(), others));
  for (const std::uint32_t i : uncertain) stays[i] = 1;
  return stays;
}

// Returns the components near `min_component` with a vertex farther than `allowed` from the mesh's
// components below `max_diagonal`.
std::vector<char> ExpectedComponents::absent(const std::vector<Vec3>& vertices,
                                             const MeshComponents& all, double max_diagonal) const {
  const NearestTriangle small(triangles_of(components_below(mesh, components, max_diagonal)));
  const double slack = (max_diagonal - min_component) / 2;
  std::vector<char> is_absent(all.diagonals.size(), 0);
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const std::uint32_t component = all.of_vertex[v];
    const bool is_uncertain = std::abs(all.diagonals[component] - min_component) < slack;
    if (!is_uncertain || is_absent[component] != 0) continue;
    is_absent[component] = small.distance(vertices[v]) > allowed ? 1 : 0;
  }
  return is_absent;
}

std::optional<MissingComponents> missing_components(const ReferenceSurface& reference,
                                                    const TriangleMesh& mesh,
                                                    const MeshComponents& components,
                                                    double allowed) {
  MissingComponents missing;
  for (const ComponentFit& component : fits_of_components(reference, mesh, allowed)) {
    // Some vertices of a missing component may be near another one.
    if (component.far > component.near) {
      ++missing.count;
      missing.largest_diagonal = std::max(missing.largest_diagonal, component.diagonal);
    } else if (component.far > 0) {
      return std::nullopt;
    }
  }
  if (missing.count == 0 || components.diagonals.empty()) return std::nullopt;
  const double least = *std::min_element(components.diagonals.begin(), components.diagonals.end());
  if (missing.largest_diagonal < least) {
    missing.min_component = just_above(missing.largest_diagonal, least);
  }
  return missing;
}

}  // namespace multitetra
