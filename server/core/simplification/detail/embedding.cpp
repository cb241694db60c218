#include "server/core/simplification/detail/embedding.hpp"

#include <algorithm>
#include <bit>

namespace multitetra {
namespace {

// The exponent of cells somewhat larger than the triangles are on average, which hold most
// triangles.
int cell_exponent(const CollapsingMesh& mesh, std::span<const LatticePoint> vertices) {
  constexpr std::uint32_t kSamples = 512;
  const std::uint32_t step = mesh.triangle_count() / kSamples + 1;
  std::uint64_t sides = 0;
  std::uint64_t count = 0;
  for (std::uint32_t t = 0; t < mesh.triangle_count(); t += step) {
    const auto& [p, q, r] = mesh.triangle(t);
    const TriangleBox box = box_of({vertices[p], vertices[q], vertices[r]});
    sides += static_cast<std::uint64_t>(
        std::max({box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z}));
    ++count;
  }
  return 1 + static_cast<int>(std::bit_width(sides / std::max(count, std::uint64_t{1})));
}

}  // namespace

Embedding::Embedding(const CollapsingMesh& mesh, std::span<const LatticePoint> vertices,
                     Obstacles obstacles)
    : mesh_(mesh),
      vertices_(vertices),
      obstacles_(obstacles),
      grid_(mesh.triangle_count() + obstacles.size(), cell_exponent(mesh, vertices)) {
  for (std::uint32_t t = 0; t < mesh.triangle_count() + obstacles.size(); ++t) {
    grid_.insert(t, box_of(triangle(t)));
  }
}

LatticeTriangle Embedding::triangle(std::uint32_t index) const {
  if (index >= mesh_.triangle_count()) return obstacles_[index - mesh_.triangle_count()];
  const auto& [p, q, r] = mesh_.triangle(index);
  return {vertices_[p], vertices_[q], vertices_[r]};
}

bool Embedding::allows(std::span<const std::uint32_t> ring) {
  const LatticePoint& v = vertex(CollapsingMesh::next(ring.front()));
  fan_.clear();
  boxes_.clear();
  TriangleBox all{v, v};
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const LatticePoint& first = vertex(CollapsingMesh::next(ring[k]));
    const LatticePoint& second = vertex(CollapsingMesh::previous(ring[k]));
    all = box_around(all, {first, first});
    if (k == 0 || k + 1 == ring.size()) continue;
    fan_.emplace_back(LatticeTriangle{v, first, second});
    boxes_.push_back(box_of(fan_.back().triangle()));
    for (std::size_t j = 0; j + 1 < fan_.size(); ++j) {
      if (intersect(fan_[j], fan_.back())) return false;
    }
  }
  return !grid_.visit_near(all, [&](std::uint32_t t) {
    const bool goes = std::any_of(ring.begin(), ring.end(), [t](std::uint32_t corner) {
      return CollapsingMesh::triangle_of(corner) == t;
    });
    if (goes) return false;
    const LatticePlane other(triangle(t));
    const TriangleBox box = box_of(other.triangle());
    for (std::size_t k = 0; k < fan_.size(); ++k) {
      if (boxes_[k].touches(box) && intersect(fan_[k], other)) return true;
    }
    return false;
  });
}

void Embedding::keep(std::span<const std::uint32_t> ring) {
  for (const std::uint32_t corner : ring) grid_.remove(CollapsingMesh::triangle_of(corner));
  for (std::size_t k = 0; k < fan_.size(); ++k) {
    grid_.insert(CollapsingMesh::triangle_of(ring[k + 1]), boxes_[k]);
  }
}

}  // namespace multitetra
