#include "server/certify/detail/closed_components.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace multitetra {
namespace {

Facing facing_of(double volume) {
  return volume > 0 ? Facing::kOutwards : volume < 0 ? Facing::kInwards : Facing::kUnknown;
}

}  // namespace

std::vector<Facing> facings_of(std::span<const SurfaceMeasures> measures) {
  std::vector<Facing> facings;
  for (const SurfaceMeasures& one : measures) {
    facings.push_back(one.volume ? facing_of(*one.volume) : Facing::kOpen);
  }
  return facings;
}

std::vector<Facing> facings_of(const TriangleMesh& mesh, const MeshComponents& components,
                               const std::vector<char>& is_open, double rounding) {
  constexpr std::uint32_t kNone = 0xFFFFFFFF;
  // Volumes are summed as seen from a vertex of the component, which rounds least.
  std::vector<std::uint32_t> origins(is_open.size(), kNone);
  std::vector<double> volumes(is_open.size(), 0);  // Six times the volumes.
  std::vector<double> areas(is_open.size(), 0);    // Twice the areas.
  for (const TriangleIndices& t : mesh.triangles) {
    const std::size_t component = components.of_vertex[t[0]];
    if (origins[component] == kNone) origins[component] = t[0];
    const Vec3& origin = mesh.vertices[origins[component]];
    const Vec3 a = difference(mesh.vertices[t[0]], origin);
    const Vec3 b = difference(mesh.vertices[t[1]], origin);
    const Vec3 c = difference(mesh.vertices[t[2]], origin);
    volumes[component] += dot(a, cross(b, c));
    areas[component] += length(cross(difference(b, a), difference(c, a)));
  }
  std::vector<Facing> facings(volumes.size(), Facing::kOpen);
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    // Rounding changes a volume by at most its distance times the area.
    const bool is_known = std::abs(volumes[i]) > 3 * rounding * areas[i];
    if (is_open[i] == 0) facings[i] = is_known ? facing_of(volumes[i]) : Facing::kUnknown;
  }
  return facings;
}

ClosedComponents counts_of(std::span<const Facing> facings) {
  return {.outwards = std::count(facings.begin(), facings.end(), Facing::kOutwards),
          .inwards = std::count(facings.begin(), facings.end(), Facing::kInwards)};
}

}  // namespace multitetra
