#include "server/core/simplification/detail/component_volumes.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <unordered_map>

#include "common/mesh/disjoint_sets.hpp"

namespace multitetra {
namespace {

static_assert(kMaxLatticeBits <= 20);

using Coordinates = std::array<std::int32_t, 3>;

Coordinates coordinates(const LatticePoint& p) { return {p.x, p.y, p.z}; }

// The planes that cut a component off.
class CuttingPlanes {
 public:
  // Takes the open edges of a component, first those that lie in a single plane.
  void add(const Coordinates& a, const Coordinates& b) {
    std::optional<std::size_t> free;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (a[axis] != b[axis]) continue;
      if (planes_[axis] == a[axis]) return;
      if (!planes_[axis] && !free) free = axis;
    }
    if (!free) return void(are_all_ = false);
    planes_[*free] = a[*free];
  }

  // Returns a point on all planes; nullopt if these are not all.
  [[nodiscard]] std::optional<LatticePoint> common_point() const {
    if (!are_all_) return std::nullopt;
    return LatticePoint{planes_[0].value_or(0), planes_[1].value_or(0), planes_[2].value_or(0)};
  }

 private:
  std::array<std::optional<std::int32_t>, 3> planes_;
  bool are_all_ = true;
};

std::ptrdiff_t common_coordinates(const Coordinates& a, const Coordinates& b) {
  return (a[0] == b[0] ? 1 : 0) + (a[1] == b[1] ? 1 : 0) + (a[2] == b[2] ? 1 : 0);
}

}  // namespace

ComponentVolumes::ComponentVolumes(const CollapsingMesh& mesh,
                                   std::span<const LatticePoint> vertices)
    : mesh_(mesh), vertices_(vertices), component_of_(vertices.size()), volumes_(vertices.size()) {
  find_components();
  find_volumes();
}

void ComponentVolumes::find_components() {
  DisjointSets sets(component_of_.size());
  for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
    const TriangleIndices& triangle = mesh_.triangle(t);
    sets.join(triangle[0], triangle[1]);
    sets.join(triangle[0], triangle[2]);
  }
  for (std::uint32_t v = 0; v < component_of_.size(); ++v) component_of_[v] = sets.root(v);
}

void ComponentVolumes::find_volumes() {
  std::unordered_map<std::uint32_t, CuttingPlanes> open;
  for (const bool is_in_one_plane : {true, false}) {
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t corner = CollapsingMesh::corner_of(t, k);
        if (mesh_.opposite(corner) != CollapsingMesh::kNone) continue;
        const std::uint32_t end = mesh_.vertex(CollapsingMesh::next(corner));
        const Coordinates a = coordinates(vertices_[end]);
        const Coordinates b =
            coordinates(vertices_[mesh_.vertex(CollapsingMesh::previous(corner))]);
        if ((common_coordinates(a, b) == 1) != is_in_one_plane) continue;
        open[component_of_[end]].add(a, b);
      }
    }
  }
  std::uint32_t component = CollapsingMesh::kNone;  // The last triangle's.
  std::optional<LatticePoint> origin;
  for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
    const auto& [a, b, c] = mesh_.triangle(t);
    if (component_of_[a] != component) {
      component = component_of_[a];
      const auto cut = open.find(component);
      origin = cut == open.end() ? LatticePoint{} : cut->second.common_point();
    }
    if (origin) volumes_[component] += volume_seen_from(*origin, a, b, c);
  }
}

ComponentVolumes::Volume ComponentVolumes::volume_seen_from(const LatticePoint& origin,
                                                            std::uint32_t a, std::uint32_t b,
                                                            std::uint32_t c) const {
  const auto from_origin = [&](std::uint32_t vertex) {
    const LatticePoint& p = vertices_[vertex];
    return std::array<std::int64_t, 3>{p.x - origin.x, p.y - origin.y, p.z - origin.z};
  };
  const auto p = from_origin(a);
  const auto q = from_origin(b);
  const auto r = from_origin(c);
  return static_cast<Volume>(p[0] * (q[1] * r[2] - q[2] * r[1]) +
                             p[1] * (q[2] * r[0] - q[0] * r[2]) +
                             p[2] * (q[0] * r[1] - q[1] * r[0]));
}

// Seen from w_0, the triangles that the collapse leaves have no volume.
ComponentVolumes::Volume ComponentVolumes::loss(std::span<const std::uint32_t> ring) const {
  const LatticePoint& goal = vertices_[mesh_.vertex(CollapsingMesh::next(ring[0]))];
  const std::uint32_t u = mesh_.vertex(ring[0]);
  Volume sum = 0;
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
    sum += volume_seen_from(goal, u, mesh_.vertex(CollapsingMesh::next(ring[i])),
                            mesh_.vertex(CollapsingMesh::previous(ring[i])));
  }
  return sum;
}

bool ComponentVolumes::keep_sign(std::span<const std::uint32_t> ring) const {
  const Volume now = volumes_[component_of_[mesh_.vertex(ring[0])]];
  if (now == 0) return true;
  const auto before = static_cast<std::int64_t>(now);
  const auto after = static_cast<std::int64_t>(now - loss(ring));
  return before > 0 ? after > 0 : after < 0;
}

void ComponentVolumes::commit(std::span<const std::uint32_t> ring) {
  Volume& volume = volumes_[component_of_[mesh_.vertex(ring[0])]];
  if (volume != 0) volume -= loss(ring);
}

}  // namespace multitetra
