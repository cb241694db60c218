#include "server/core/collapsing_mesh.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace multitetra {

CollapsingMesh::CollapsingMesh(std::span<const TriangleIndices> triangles,
                               std::uint32_t vertex_count)
    : triangles_(triangles.begin(), triangles.end()),
      removed_(triangles.size(), 0),
      opposite_(3 * triangles.size(), kNone),
      corner_of_(vertex_count, kNone),
      valences_(vertex_count, 0),
      kinds_(vertex_count, VertexKind::kInner),
      marks_(vertex_count, 0) {
  find_opposites();
  find_kinds();
}

// Every corner is filed under the vertex where the edge opposite to it begins.
void CollapsingMesh::find_opposites() {
  const auto corners = static_cast<std::uint32_t>(opposite_.size());
  std::vector<std::uint32_t> begin(kinds_.size() + 1, 0);
  for (std::uint32_t c = 0; c < corners; ++c) ++begin[vertex(next(c)) + 1];
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  std::vector<std::uint32_t> filed(corners);
  std::vector<std::uint32_t> end(begin.begin(), begin.end() - 1);
  for (std::uint32_t c = 0; c < corners; ++c) filed[end[vertex(next(c))]++] = c;
  // The only edge from one vertex to another; an edge of more than two triangles is none.
  const auto find = [&](std::uint32_t from, std::uint32_t to) {
    std::uint32_t found = kNone;
    for (std::uint32_t i = begin[from]; i < begin[from + 1]; ++i) {
      if (vertex(previous(filed[i])) != to) continue;
      if (found != kNone) {
        kinds_[from] = kinds_[to] = VertexKind::kIrregular;
        return kNone;
      }
      found = filed[i];
    }
    return found;
  };
  for (std::uint32_t c = 0; c < corners; ++c) {
    const std::uint32_t from = vertex(next(c));
    const std::uint32_t to = vertex(previous(c));
    corner_of_[vertex(c)] = c;
    if (find(from, to) == c) opposite_[c] = find(to, from);
  }
}

// A vertex is irregular unless walking around it meets all of its corners.
void CollapsingMesh::find_kinds() {
  for (const TriangleIndices& t : triangles_) {
    for (const std::uint32_t v : t) ++valences_[v];
  }
  for (std::uint32_t v = 0; v < kinds_.size(); ++v) {
    if (corner_of_[v] == kNone) kinds_[v] = VertexKind::kIrregular;
    if (kinds_[v] == VertexKind::kIrregular) continue;
    const std::uint32_t first = corner_of_[v];
    std::uint32_t met = 0;
    std::uint32_t at = first;
    do {
      ++met;
      const std::uint32_t across = opposite_[next(at)];
      at = across == kNone ? kNone : next(across);
    } while (at != kNone && at != first && met <= valences_[v]);
    if (at == first) {
      if (met != valences_[v]) kinds_[v] = VertexKind::kIrregular;
      continue;
    }
    for (at = opposite_[previous(first)]; at != kNone && met <= valences_[v];
         at = opposite_[previous(previous(at))]) {
      ++met;
    }
    kinds_[v] = met == valences_[v] ? VertexKind::kBorder : VertexKind::kIrregular;
  }
}

void CollapsingMesh::ring(std::uint32_t inner, std::vector<std::uint32_t>& corners) const {
  corners.clear();
  const std::uint32_t first = corner_of_[inner];
  std::uint32_t at = first;
  do {
    corners.push_back(at);
    at = next(opposite_[next(at)]);
  } while (at != first);
}

void CollapsingMesh::turn(std::vector<std::uint32_t>& corners, std::size_t first) {
  std::rotate(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(first), corners.end());
}

template <typename Visit>
void CollapsingMesh::visit_neighbours(std::uint32_t vertex_index, const Visit& visit) const {
  const std::uint32_t first = corner_of_[vertex_index];
  std::uint32_t at = first;
  do {
    visit(vertex(next(at)));
    const std::uint32_t across = opposite_[next(at)];
    if (across == kNone) {
      // An open fan: its last neighbour, and then those on the other side of the first corner.
      visit(vertex(previous(at)));
      for (at = first; opposite_[previous(at)] != kNone;) {
        at = previous(opposite_[previous(at)]);
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
  // Three triangles become one: there must not be its back already.
  if (ring.size() > 3) return true;
  const std::uint32_t across = opposite_[ring[1]];
  return across == kNone || vertex(across) != v;
}

void CollapsingMesh::link(std::uint32_t corner, std::uint32_t other) {
  opposite_[corner] = other;
  if (other != kNone) opposite_[other] = corner;
}

void CollapsingMesh::collapse(std::span<const std::uint32_t> ring) {
  const std::size_t last = ring.size() - 1;
  const std::uint32_t v = vertex(next(ring[0]));
  for (std::size_t i = 1; i < last; ++i) triangles_[ring[i] / 3][ring[i] % 3] = v;
  removed_[ring[0] / 3] = removed_[ring[last] / 3] = 1;
  link(previous(ring[1]), opposite_[ring[0]]);
  link(next(ring[last - 1]), opposite_[ring[last]]);
  corner_of_[v] = ring[1];
  corner_of_[vertex(next(ring[1]))] = next(ring[1]);
  corner_of_[vertex(previous(ring[last - 1]))] = previous(ring[last - 1]);
  valences_[v] += static_cast<std::uint32_t>(ring.size()) - 4;
  --valences_[vertex(next(ring[1]))];
  --valences_[vertex(previous(ring[last - 1]))];
}

void CollapsingMesh::take_back(std::uint32_t u, std::span<const std::uint32_t> ring) {
  const std::size_t last = ring.size() - 1;
  const std::uint32_t v = vertex(next(ring[0]));
  for (std::size_t i = 1; i < last; ++i) triangles_[ring[i] / 3][ring[i] % 3] = u;
  removed_[ring[0] / 3] = removed_[ring[last] / 3] = 0;
  link(ring[0], opposite_[previous(ring[1])]);
  link(ring[last], opposite_[next(ring[last - 1])]);
  link(previous(ring[1]), next(ring[0]));
  link(next(ring[last - 1]), previous(ring[last]));
  corner_of_[v] = next(ring[0]);
  valences_[v] -= static_cast<std::uint32_t>(ring.size()) - 4;
  ++valences_[vertex(next(ring[1]))];
  ++valences_[vertex(previous(ring[last - 1]))];
}

}  // namespace multitetra
