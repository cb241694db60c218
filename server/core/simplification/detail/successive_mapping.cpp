#include "server/core/simplification/detail/successive_mapping.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <utility>

namespace multitetra {

double StoredMapping::bound() const { return largest * (1 + kRounding); }

void StoredMapping::append(const StoredMapping& other, std::span<const std::uint32_t> vertices,
                           std::uint32_t first_triangle) {
  std::size_t count = carriers.size();
  for (const std::uint32_t v : vertices) count = std::max(count, std::size_t{v} + 1);
  carriers.resize(count, kNone);
  for (std::size_t v = 0; v < other.carriers.size(); ++v) {
    if (other.carriers[v] != kNone) carriers[vertices[v]] = first_triangle + other.carriers[v];
  }
  std::uint32_t begin = 0;
  for (const Edge& edge : other.edges) {
    const auto from = crossings.size();
    for (std::uint32_t i = begin; i < edge.end; ++i) {
      crossings.push_back(4 * first_triangle + other.crossings[i]);
    }
    begin = edge.end;
    Edge added = {.low = vertices[edge.low],
                  .high = vertices[edge.high],
                  .end = static_cast<std::uint32_t>(crossings.size())};
    if (added.low > added.high) {
      std::swap(added.low, added.high);
      std::reverse(crossings.begin() + static_cast<std::ptrdiff_t>(from), crossings.end());
    }
    edges.push_back(added);
  }
  largest = std::max(largest, other.largest);
}

SuccessiveMapping::SuccessiveMapping(const CollapsingMesh& mesh,
                                     std::span<const CollapseFan::Point> points,
                                     const StoredMapping& map, std::span<const std::uint32_t> parts,
                                     const PieceLimit& limit)
    : mesh_(mesh),
      points_(points),
      limit_(limit),
      edge_of_(4 * std::size_t{mesh.triangle_count()}, kNone),
      halves_begin_(points.size() + 1, 0),
      vertices_(points.size()),
      is_carried_(points.size(), 0),
      first_carried_(mesh.triangle_count(), kNone),
      largest_(map.largest) {
  number_edges();
  add_edges(map, parts);
  add_crossings(map);
  for (std::uint32_t v = 0; v < map.carriers.size(); ++v) {
    if (map.carriers[v] == kNone) continue;
    is_carried_[v] = 1;
    vertices_[v].next_carried = std::exchange(first_carried_[map.carriers[v]], v);
  }
}

void SuccessiveMapping::number_edges() {
  std::uint32_t count = 0;
  for (std::uint32_t c = 0; c < edge_of_.size(); ++c) {
    if (c % 4 == 3 || edge_of_[c] != kNone) continue;
    const std::uint32_t across = mesh_.opposite(c);
    edge_of_[c] = count++;
    if (across != kNone) edge_of_[across] = edge_of_[c];
  }
  edges_.resize(count);
}

// Border edges are omitted: they are never needed, as their ends are never carried.
void SuccessiveMapping::add_edges(const StoredMapping& map, std::span<const std::uint32_t> parts) {
  const auto visit_edges = [&](const auto& visit) {
    for (const StoredMapping::Edge& edge : map.edges) visit(edge.low, edge.high);
    for (std::uint32_t c = 0; c < edge_of_.size(); ++c) {
      if (c % 4 == 3) continue;
      const std::uint32_t across = mesh_.opposite(c);
      if (across == kNone || across < c) continue;
      const bool is_known = !parts.empty() && parts[CollapsingMesh::triangle_of(c)] ==
                                                  parts[CollapsingMesh::triangle_of(across)];
      if (is_known) continue;
      visit(mesh_.vertex(CollapsingMesh::next(c)), mesh_.vertex(CollapsingMesh::previous(c)));
    }
  };
  visit_edges([&](std::uint32_t p, std::uint32_t q) {
    ++halves_begin_[p + 1];
    ++halves_begin_[q + 1];
  });
  for (std::size_t v = 1; v < halves_begin_.size(); ++v) halves_begin_[v] += halves_begin_[v - 1];
  halves_.resize(halves_begin_.back());
  std::vector<std::uint32_t> end(halves_begin_.begin(), halves_begin_.end() - 1);
  visit_edges([&](std::uint32_t p, std::uint32_t q) {
    const std::uint32_t at_p = end[p]++;
    const std::uint32_t at_q = end[q]++;
    halves_[at_p] = {.other = q, .twin = at_q};
    halves_[at_q] = {.other = p, .twin = at_p};
  });
}

// At every vertex the map's edges come first, in the map's order.
void SuccessiveMapping::add_crossings(const StoredMapping& map) {
  std::vector<std::uint32_t> next(halves_begin_.begin(), halves_begin_.end() - 1);
  crossings_.reserve(map.crossings.size());
  std::uint32_t i = 0;
  for (const StoredMapping::Edge& edge : map.edges) {
    const std::uint32_t low = next[edge.low]++;
    ++next[edge.high];
    std::uint32_t before = kNone;
    for (; i < edge.end; ++i) {
      const std::uint32_t on = edge_of_[map.crossings[i]];
      crossings_.push_back(
          {.half = low, .on = on, .previous = before, .next_on = edges_[on].crossed});
      edges_[on].crossed = i;
      (before == kNone ? halves_[low].first : crossings_[before].next) = i;
      before = i;
    }
    halves_[halves_[low].twin].first = before;
  }
}

StoredMapping SuccessiveMapping::map(std::span<const std::uint32_t> numbers) const {
  StoredMapping map{.carriers = std::vector<std::uint32_t>(points_.size(), kNone),
                    .edges = {},
                    .crossings = {},
                    .largest = largest_};
  std::vector<std::uint32_t> corner_at(edges_.size(), kNone);
  for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
    if (mesh_.is_removed(t)) continue;
    for (std::uint32_t p = first_carried_[t]; p != kNone; p = vertices_[p].next_carried) {
      map.carriers[p] = numbers[t];
    }
    for (std::uint32_t k = 0; k < 3; ++k) {
      corner_at[edge_of_[CollapsingMesh::corner_of(t, k)]] =
          CollapsingMesh::corner_of(numbers[t], k);
    }
  }
  map.edges.reserve(halves_.size() / 2);
  for (std::uint32_t low = 0; low < points_.size(); ++low) {
    for (std::uint32_t h = halves_begin_[low]; h < halves_begin_[low + 1]; ++h) {
      if (halves_[h].other < low) continue;
      for (std::uint32_t c = halves_[h].first; c != kNone; c = crossings_[c].next) {
        map.crossings.push_back(corner_at[crossings_[c].on]);
      }
      map.edges.push_back({.low = low,
                           .high = halves_[h].other,
                           .end = static_cast<std::uint32_t>(map.crossings.size())});
    }
  }
  map.crossings.shrink_to_fit();
  return map;
}

void SuccessiveMapping::mark(std::span<const std::uint32_t> ring) {
  for (std::uint32_t i = 0; i < ring.size(); ++i) {
    Vertex& w = vertices_[mesh_.vertex(CollapsingMesh::next(ring[i]))];
    w.last_collapse = kRingOffset + collapse_number_;
    w.sectors = {std::max(i, 2U) - 1, std::min(i, fan_.sectors())};
    if (i == 0) w.sectors = {1, fan_.sectors()};
    Edge& across = edges_[edge_of_[ring[i]]];
    across.last_collapse = collapse_number_;
    across.place = i;
    Edge& spoke = edges_[edge_of_[CollapsingMesh::previous(ring[i])]];
    spoke.last_collapse = collapse_number_;
    spoke.place = kFanEdge;
  }
}

bool SuccessiveMapping::place(std::uint32_t vertex) {
  const auto sector = fan_.sector_near(points_[vertex]);
  if (!sector) return false;
  vertices_[vertex].last_collapse = collapse_number_;
  vertices_[vertex].sectors = {*sector, *sector};
  placed_.push_back(vertex);
  return true;
}

bool SuccessiveMapping::fits(std::span<const std::uint32_t> ring,
                             std::span<const Vec3> ring_positions) {
  return limit_.is_uniform() ? measure(ring, ring_positions, limit_.largest())
                             : measure_locally(ring, ring_positions);
}

bool SuccessiveMapping::measure(std::span<const std::uint32_t> ring,
                                std::span<const Vec3> ring_positions, double limit) {
  ++collapse_number_;
  placed_.clear();
  segments_.clear();
  // Ensures bound() <= limit.
  fan_.set_up(ring_positions, std::min(limit, kLargestLimit) * (1 - 2 * StoredMapping::kRounding));
  if (!place(mesh_.vertex(ring[0]))) return false;
  for (const std::uint32_t corner : ring) {
    for (std::uint32_t p = first_carried_[CollapsingMesh::triangle_of(corner)]; p != kNone;
         p = vertices_[p].next_carried) {
      if (!place(p)) return false;
    }
  }
  mark(ring);
  return find_segments_of_vertices() && find_passing_segments(ring);
}

// First assumes that only the fan's own limit applies, then includes all that lies in it.
bool SuccessiveMapping::measure_locally(std::span<const std::uint32_t> ring,
                                        std::span<const Vec3> ring_positions) {
  const Box fan = box_of(ring_positions);
  double limit = limit_.least_near(fan, 0, 0);
  for (int tries = 0; tries < 2 && limit > 0; ++tries) {
    if (!measure(ring, ring_positions, limit)) return false;
    region_ = fan;
    largest_error_ = 0;
    if (!measure_rim(ring, ring_positions)) return false;
    for (const std::uint32_t p : placed_) {
      include(p);
      for (std::uint32_t h = halves_begin_[p]; h < halves_begin_[p + 1]; ++h) {
        include(halves_[h].other);
      }
    }
    const double distance = fan_.largest();
    const double allowed = limit_.least_near(region_, largest_error_, distance);
    if (distance <= allowed * (1 - 2 * StoredMapping::kRounding)) return true;
    limit = allowed;
  }
  return false;
}

// Measures the fan's other pairs: its vertices, and the edges that cross its rim. These include all
// edges that pass through it.
bool SuccessiveMapping::measure_rim(std::span<const std::uint32_t> ring,
                                    std::span<const Vec3> ring_positions) {
  for (std::uint32_t i = 0; i < ring.size(); ++i) {
    const std::uint32_t w = mesh_.vertex(CollapsingMesh::next(ring[i]));
    if (!fan_.is_near(points_[w].error)) return false;
    include(w);
    const Vec3& begin = ring_positions[i];
    const Vec3& end = ring_positions[i + 1 < ring.size() ? i + 1 : 0];
    for (std::uint32_t c = edges_[edge_of_[ring[i]]].crossed; c != kNone;
         c = crossings_[c].next_on) {
      if (crossings_[c].half == kNone) continue;
      const auto [low, high] = ends(crossings_[c].half);
      if (!fan_.is_near_rim(points_[low], points_[high], begin, end)) return false;
      include(low);
      include(high);
    }
  }
  // Passing edges enter across the rim.
  return true;
}

void SuccessiveMapping::include(std::uint32_t vertex) {
  multitetra::include(region_, points_[vertex].at);
  largest_error_ = std::max(largest_error_, points_[vertex].error);
}

bool SuccessiveMapping::find_segments_of_vertices() {
  for (const std::uint32_t p : placed_) {
    const std::uint32_t sector = vertices_[p].sectors.first;
    for (std::uint32_t h = halves_begin_[p]; h < halves_begin_[p + 1]; ++h) {
      const HalfEdge& half = halves_[h];
      const bool from_low = p < half.other;
      std::uint32_t c = half.first;
      while (c != kNone && is_fan_edge(crossings_[c].on)) {
        crossings_[c].last_collapse = collapse_number_;
        c = from_low ? crossings_[c].next : crossings_[c].previous;
      }
      if (c == kNone) {
        const Vertex& other = vertices_[half.other];
        // Adding it from one of its two ends suffices.
        if (!from_low && other.last_collapse == collapse_number_) continue;
        if (half.first == kNone && other.sectors.first <= sector && sector <= other.sectors.last) {
          continue;
        }
      }
      if (!(from_low ? add_segment(h, p, half.other, kNone, c, half.first != c)
                     : add_segment(half.twin, half.other, p, c, kNone, half.first != c))) {
        return false;
      }
    }
  }
  return true;
}

bool SuccessiveMapping::find_passing_segments(std::span<const std::uint32_t> ring) {
  for (const std::uint32_t corner : ring) {
    const std::uint32_t spoke = edge_of_[CollapsingMesh::previous(corner)];
    for (std::uint32_t c = edges_[spoke].crossed; c != kNone; c = crossings_[c].next_on) {
      if (crossings_[c].half == kNone || crossings_[c].last_collapse == collapse_number_) continue;
      std::uint32_t before = c;
      while (before != kNone && is_fan_edge(crossings_[before].on)) {
        crossings_[before].last_collapse = collapse_number_;
        before = crossings_[before].previous;
      }
      std::uint32_t after = c;
      while (after != kNone && is_fan_edge(crossings_[after].on)) {
        crossings_[after].last_collapse = collapse_number_;
        after = crossings_[after].next;
      }
      const auto [low, high] = ends(crossings_[c].half);
      if (!add_segment(crossings_[c].half, low, high, before, after, true)) return false;
    }
  }
  return true;
}

SuccessiveMapping::Sectors SuccessiveMapping::sectors_at(std::uint32_t crossing,
                                                         std::uint32_t vertex) const {
  if (crossing == kNone) {
    assert(vertices_[vertex].last_collapse == collapse_number_ ||
           vertices_[vertex].last_collapse == collapse_number_ + kRingOffset);
    return vertices_[vertex].sectors;
  }
  const Edge& on = edges_[crossings_[crossing].on];
  assert(on.last_collapse == collapse_number_ && on.place != kFanEdge);
  const std::uint32_t sector = std::clamp(on.place, 1U, fan_.sectors());
  return {sector, sector};
}

bool SuccessiveMapping::add_segment(std::uint32_t half, std::uint32_t low, std::uint32_t high,
                                    std::uint32_t before, std::uint32_t after, bool had_crossings) {
  const auto is_near = [&](std::uint32_t first, std::uint32_t last) {
    return fan_.is_near(points_[low], points_[high], first, last);
  };
  const Sectors from = sectors_at(before, low);
  const Sectors to = sectors_at(after, high);
  OverlaySegment segment{.half = half, .before = before, .after = after, .from = 0, .to = 0};
  if (from.last < to.first) {
    segment.from = from.last;
    segment.to = to.first;
    if (!is_near(from.last + 1, to.first)) return false;
  } else if (to.last < from.first) {
    segment.from = from.first;
    segment.to = to.last;
    if (!is_near(to.last + 1, from.first)) return false;
  } else if (!had_crossings) {
    return true;
  }
  segments_.push_back(segment);
  return true;
}

void SuccessiveMapping::commit(std::span<const std::uint32_t> ring) {
  for (const std::uint32_t corner : ring) {
    first_carried_[CollapsingMesh::triangle_of(corner)] = kNone;
    Edge& spoke = edges_[edge_of_[CollapsingMesh::previous(corner)]];
    while (spoke.crossed != kNone) {
      const std::uint32_t c = spoke.crossed;
      spoke.crossed = crossings_[c].next_on;
      crossings_[c].next_on = free_;
      free_ = c;
    }
  }
  for (const std::uint32_t vertex : placed_) {
    std::uint32_t& first =
        first_carried_[CollapsingMesh::triangle_of(ring[vertices_[vertex].sectors.first])];
    vertices_[vertex].next_carried = first;
    first = vertex;
  }
  for (const OverlaySegment& segment : segments_) commit_segment(segment, ring);
  is_carried_[placed_.front()] = 1;
  edge_of_[CollapsingMesh::previous(ring[1])] = edge_of_[ring[0]];
  edge_of_[CollapsingMesh::next(ring[fan_.sectors()])] = edge_of_[ring.back()];
  largest_ = std::max(largest_, fan_.largest());
}

void SuccessiveMapping::commit_segment(const OverlaySegment& segment,
                                       std::span<const std::uint32_t> ring) {
  std::uint32_t before = segment.before;
  std::uint32_t after = segment.after;
  if (before != kNone && after != kNone && crossings_[before].on == crossings_[after].on) {
    // It enters and leaves across the same edge, so both crossings cancel.
    crossings_[before].half = crossings_[after].half = kNone;
    before = crossings_[before].previous;
    after = crossings_[after].next;
  }
  HalfEdge& low = halves_[segment.half];
  const auto link = [&](std::uint32_t c) {
    (before == kNone ? low.first : crossings_[before].next) = c;
    if (c != kNone) crossings_[c].previous = before;
    before = c;
  };
  for (std::uint32_t k = segment.from; k != segment.to; k < segment.to ? ++k : --k) {
    const std::uint32_t on = edge_of_[CollapsingMesh::previous(ring[k < segment.to ? k + 1 : k])];
    std::uint32_t c = free_;
    if (c == kNone) {
      c = static_cast<std::uint32_t>(crossings_.size());
      crossings_.emplace_back();
    } else {
      free_ = crossings_[c].next_on;
    }
    crossings_[c] = {.half = segment.half, .on = on, .next_on = edges_[on].crossed};
    edges_[on].crossed = c;
    link(c);
  }
  const std::uint32_t last = before;
  link(after);
  if (after == kNone) halves_[low.twin].first = last;
}

}  // namespace multitetra
