#include "server/core/simplification/detail/embedding.hpp"

#include <algorithm>
#include <cstddef>

#include "server/core/simplification/detail/star_projection.hpp"

namespace multitetra {
namespace {

// Fans with more triangles are not tracked by bit mask.
constexpr std::size_t kMaxBits = 64;

std::vector<TriangleBox> boxes_of(const CollapsingMesh& mesh,
                                  std::span<const LatticePoint> vertices, Obstacles obstacles) {
  std::vector<TriangleBox> boxes;
  boxes.reserve(mesh.triangle_count() + obstacles.size());
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    const auto& [p, q, r] = mesh.triangle(t);
    boxes.push_back(box_of({vertices[p], vertices[q], vertices[r]}));
  }
  for (const LatticeTriangle& triangle : obstacles) boxes.push_back(box_of(triangle));
  return boxes;
}

}  // namespace

Embedding::Embedding(const CollapsingMesh& mesh, std::span<const LatticePoint> vertices,
                     Obstacles obstacles)
    : mesh_(mesh),
      vertices_(vertices),
      obstacles_(obstacles),
      tree_(boxes_of(mesh, vertices, obstacles)),
      ring_vertices_(vertices.size()),
      removed_in_(mesh.triangle_count() + obstacles.size(), 0) {
  turns_.reserve(mesh.triangle_count());
  for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
    turns_.emplace_back(LatticePlane(triangle(t)).normal());
  }
}

LatticeTriangle Embedding::triangle(std::uint32_t index) const {
  if (index >= mesh_.triangle_count()) return obstacles_[index - mesh_.triangle_count()];
  const auto& [p, q, r] = mesh_.triangle(index);
  return {vertices_[p], vertices_[q], vertices_[r]};
}

bool Embedding::allows(std::span<const std::uint32_t> ring) {
  set_up_fan(ring);
  find_disjoint_stars(ring);
  if (fan_meets_itself()) return false;
  TriangleBox all = fan_.front().box;
  for (const FanTriangle& one : fan_) all = box_around(all, one.box);
  return !tree_.visit_near(all, [this](std::uint32_t t) { return fan_meets(t); });
}

void Embedding::set_up_fan(std::span<const std::uint32_t> ring) {
  ++collapse_number_;
  fan_.clear();
  const auto vertex = [&](std::size_t place) {
    return mesh_.vertex(CollapsingMesh::next(ring[place]));
  };
  for (std::uint32_t place = 0; place < ring.size(); ++place) {
    ring_vertices_[vertex(place)] = {.last_collapse = collapse_number_, .place = place};
    removed_in_[CollapsingMesh::triangle_of(ring[place])] = collapse_number_;
    if (place == 0 || place + 1 == ring.size()) continue;
    const LatticeTriangle one = {vertices_[vertex(0)], vertices_[vertex(place)],
                                 vertices_[vertex(place + 1)]};
    const LatticePlane plane(one);
    fan_.push_back({plane, box_of(one), OrientationMask(plane.normal())});
  }
}

// The star of w_0 contains all triangles of the fan; that of w_k those before and after it.
void Embedding::find_disjoint_stars(std::span<const std::uint32_t> ring) {
  disjoint_stars_.assign(ring.size(), 0);
  if (fan_.size() > kMaxBits) return;
  for (std::uint32_t place = 0; place < ring.size(); ++place) {
    if (!is_star_clear(ring, place)) continue;
    if (place == 0) {
      disjoint_stars_[place] = ~std::uint64_t{0};
      continue;
    }
    if (place > 1) disjoint_stars_[place] |= std::uint64_t{1} << (place - 2);
    if (place <= fan_.size()) disjoint_stars_[place] |= std::uint64_t{1} << (place - 1);
  }
}

// Tests the star after the collapse. Around w_0, the rest of u's ring replaces u; around other
// vertices w_0 does.
bool Embedding::is_star_clear(std::span<const std::uint32_t> ring, std::uint32_t place) {
  const std::uint32_t center = mesh_.vertex(CollapsingMesh::next(ring[place]));
  if (mesh_.kind(center) != CollapsingMesh::VertexKind::kInner) return false;
  const std::uint32_t u = mesh_.vertex(ring[0]);
  const std::uint32_t v = mesh_.vertex(CollapsingMesh::next(ring[0]));
  const bool is_beside_goal = place == 1 || place + 1 == ring.size();
  mesh_.ring(center, corners_);
  const OrientationMask turns = turns_around(place);
  if (!turns.any()) return false;
  around_.clear();
  for (const std::uint32_t corner : corners_) {
    const std::uint32_t w = mesh_.vertex(CollapsingMesh::next(corner));
    if (w != u) {
      around_.push_back(vertices_[w]);
    } else if (place == 0) {
      for (std::size_t k = 2; k + 1 < ring.size(); ++k) {
        around_.push_back(vertices_[mesh_.vertex(CollapsingMesh::next(ring[k]))]);
      }
    } else if (!is_beside_goal) {
      around_.push_back(vertices_[v]);
    }
  }
  return winds_once(vertices_[center], around_, turns);
}

// Returns the common turns of the unchanged triangles at `corners_` and the fan's there.
OrientationMask Embedding::turns_around(std::uint32_t place) const {
  OrientationMask turns;
  for (const std::uint32_t corner : corners_) {
    const std::uint32_t t = CollapsingMesh::triangle_of(corner);
    if (removed_in_[t] != collapse_number_) turns.intersect(turns_[t]);
  }
  for (std::size_t k = 0; k < fan_.size(); ++k) {
    if (place == 0 || k + 1 == place || k + 2 == place) turns.intersect(fan_[k].turns);
  }
  return turns;
}

bool Embedding::fan_meets_itself() const {
  if (disjoint_stars_[0] != 0) return false;
  for (std::size_t k = 1; k < fan_.size(); ++k) {
    for (std::size_t j = 0; j < k; ++j) {
      if (intersect(fan_[j].plane, fan_[k].plane)) return true;
    }
  }
  return false;
}

std::uint64_t Embedding::cleared(std::uint32_t triangle) const {
  if (triangle >= mesh_.triangle_count()) return 0;
  std::uint64_t bits = 0;
  for (const std::uint32_t w : mesh_.triangle(triangle)) {
    if (ring_vertices_[w].last_collapse == collapse_number_)
      bits |= disjoint_stars_[ring_vertices_[w].place];
  }
  return bits;
}

bool Embedding::fan_meets(std::uint32_t t) const {
  if (removed_in_[t] == collapse_number_) return false;
  const std::uint64_t bits = cleared(t);
  if (bits == ~std::uint64_t{0}) return false;
  const LatticeTriangle other = triangle(t);
  const TriangleBox box = box_of(other);
  for (std::size_t k = 0; k < fan_.size(); ++k) {
    if (k < kMaxBits && (bits >> k & 1) != 0) continue;
    if (!fan_[k].box.touches(box) || touches_only_shared_corners(fan_[k].plane, other)) continue;
    if (intersect(fan_[k].plane, LatticePlane(other))) return true;
  }
  return false;
}

void Embedding::commit(std::span<const std::uint32_t> ring) {
  tree_.remove(CollapsingMesh::triangle_of(ring.front()));
  tree_.remove(CollapsingMesh::triangle_of(ring.back()));
  for (std::size_t k = 0; k < fan_.size(); ++k) {
    const std::uint32_t t = CollapsingMesh::triangle_of(ring[k + 1]);
    tree_.set(t, fan_[k].box);
    turns_[t] = fan_[k].turns;
  }
}

}  // namespace multitetra
