#include "server/core/simplification/detail/collapsing_mesh.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <utility>

namespace multitetra {

CollapsingMesh::CollapsingMesh(std::span<const TriangleIndices> triangles,
                               std::uint32_t vertex_count)
    : corner_of_(vertex_count, kNone),
      kinds_(vertex_count, VertexKind::kInner),
      marks_(vertex_count, 0) {
  triangles_.reserve(triangles.size());
  for (const TriangleIndices& t : triangles) triangles_.push_back({.vertices = t});
  find_opposites();
  find_kinds();
}

// Files every corner under the lesser end of its opposite edge: first the corners whose edges lead
// from there, then those whose edges lead to it. An edge has opposites only if it belongs to
// exactly two triangles, one in each direction.
void CollapsingMesh::find_opposites() {
  struct Filed {
    std::uint32_t other = 0;  // The edge's greater end.
    std::uint32_t corner = 0;
  };
  std::vector<std::uint32_t> begin(kinds_.size() + 1, 0);
  for (const Triangle& t : triangles_) {
    const auto [p, q, r] = t.vertices;
    ++begin[std::min(p, q) + 1];
    ++begin[std::min(q, r) + 1];
    ++begin[std::min(r, p) + 1];
  }
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<Filed> filed(begin.back());
  struct Free {
    std::uint32_t begin = 0, end = 0;
  };
  std::vector<Free> free(kinds_.size());
  for (std::size_t v = 0; v < free.size(); ++v) free[v] = {begin[v], begin[v + 1]};
  for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t c = corner_of(i, k);
      const std::uint32_t from = vertex(next(c));
      const std::uint32_t to = vertex(previous(c));
      if (from < to) {
        filed[free[from].begin++] = {to, c};
      } else {
        filed[--free[to].end] = {from, c};
      }
      corner_of_[vertex(c)] = c;
    }
  }
  // Returns the number of these edges that lead to a vertex, and the corner of the last.
  const auto find = [&filed](std::uint32_t first, std::uint32_t last, std::uint32_t other) {
    std::pair<int, std::uint32_t> found = {0, kNone};
    for (std::uint32_t i = first; i < last; ++i) {
      if (filed[i].other == other) found = {found.first + 1, filed[i].corner};
    }
    return found;
  };
  for (std::uint32_t v = 0; v < free.size(); ++v) {
    const std::uint32_t middle = free[v].end;
    for (std::uint32_t i = begin[v]; i < middle; ++i) {
      const auto [other, corner] = filed[i];
      const auto [back, across] = find(middle, begin[v + 1], other);
      if (back == 1 && find(begin[v], middle, other).first == 1) link(corner, across);
    }
  }
}

// A vertex is irregular unless a walk around it visits all of its corners.
void CollapsingMesh::find_kinds() {
  std::vector<std::uint32_t> valences(kinds_.size(), 0);
  for (const Triangle& t : triangles_) {
    for (const std::uint32_t v : t.vertices) ++valences[v];
  }
  for (std::uint32_t v = 0; v < kinds_.size(); ++v) {
    const std::uint32_t first = corner_of_[v];
    if (first == kNone) {
      kinds_[v] = VertexKind::kIrregular;
      continue;
    }
    std::uint32_t met = 0;
    std::uint32_t at = first;
    do {
      ++met;
      const std::uint32_t across = opposite(next(at));
      at = across == kNone ? kNone : next(across);
    } while (at != kNone && at != first);
    const bool is_closed = at == first;
    if (!is_closed) {
      for (at = opposite(previous(first)); at != kNone; at = opposite(previous(previous(at)))) {
        ++met;
      }
    }
    if (met != valences[v]) {
      kinds_[v] = VertexKind::kIrregular;
    } else if (!is_closed) {
      kinds_[v] = VertexKind::kBorder;
    }
  }
}

void CollapsingMesh::ring(std::uint32_t inner, std::vector<std::uint32_t>& corners) const {
  corners.clear();
  const std::uint32_t first = corner_of_[inner];
  std::uint32_t at = first;
  do {
    corners.push_back(at);
    at = next(opposite(next(at)));
  } while (at != first);
}

template <typename Visit>
void CollapsingMesh::visit_neighbours(std::uint32_t vertex_index, const Visit& visit) const {
  const std::uint32_t first = corner_of_[vertex_index];
  std::uint32_t at = first;
  do {
    visit(vertex(next(at)));
    const std::uint32_t across = opposite(next(at));
    if (across == kNone) {
      // An open fan: visits its last neighbour, then those on the other side of the first corner.
      visit(vertex(previous(at)));
      for (at = first; opposite(previous(at)) != kNone;) {
        at = previous(opposite(previous(at)));
        visit(vertex(next(at)));
      }
      return;
    }
    at = next(across);
  } while (at != first);
}

bool CollapsingMesh::keeps_topology(std::span<const std::uint32_t> ring) {
  const std::uint32_t v = vertex(next(ring.front()));
  if (kinds_[v] == VertexKind::kIrregular || ring.size() < 3) return false;
  ++mark_;
  for (const std::uint32_t c : ring) marks_[vertex(next(c))] = mark_;
  int common = 0;
  visit_neighbours(v, [&](std::uint32_t w) { common += marks_[w] == mark_ ? 1 : 0; });
  if (common != 2) return false;
  // Three triangles become one: its reverse must not exist already.
  if (ring.size() > 3) return true;
  const std::uint32_t across = opposite(ring[1]);
  return across == kNone || vertex(across) != v;
}

void CollapsingMesh::link(std::uint32_t corner, std::uint32_t other) {
  triangles_[corner / 4].opposite[corner % 4] = other;
  if (other != kNone) triangles_[other / 4].opposite[other % 4] = corner;
}

void CollapsingMesh::collapse(std::span<const std::uint32_t> ring) {
  const std::size_t last = ring.size() - 1;
  const std::uint32_t v = vertex(next(ring[0]));
  for (std::size_t i = 1; i < last; ++i) triangles_[ring[i] / 4].vertices[ring[i] % 4] = v;
  triangles_[ring[0] / 4].is_removed = triangles_[ring[last] / 4].is_removed = true;
  link(previous(ring[1]), opposite(ring[0]));
  link(next(ring[last - 1]), opposite(ring[last]));
  corner_of_[v] = ring[1];
  corner_of_[vertex(next(ring[1]))] = next(ring[1]);
  corner_of_[vertex(previous(ring[last - 1]))] = previous(ring[last - 1]);
}

}  // namespace multitetra
