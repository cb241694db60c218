#include "server/core/carried_surface.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/core/segment_distance.hpp"
#include "server/core/vectors.hpp"

namespace multitetra {

// Corners and crossings of an original triangle in their order, each with the triangles of N that
// its image lies in, among those that were met.
class CarriedSurface::Outline {
 public:
  explicit Outline(const CollapsingMesh& mesh) : mesh_(mesh) {}

  void meet(std::uint32_t triangle) {
    for (std::size_t i = 0; i < met_; ++i) {
      if (triangles_[i] == triangle) return;
    }
    triangles_[met_++] = triangle;
  }
  void add_vertex(std::uint32_t vertex) { nodes_[count_++] = {vertex, vertex, kNone}; }
  void add_crossing(std::uint32_t from, std::uint32_t to) { nodes_[count_++] = {from, to, kNone}; }
  void add_carried(std::uint32_t triangle) { nodes_[count_++] = {0, 0, triangle}; }

  // Whether chords cut it into triangles that each lie in one of those that were met.
  [[nodiscard]] bool is_cut_into_triangles() {
    for (std::size_t i = 0; i < count_; ++i) nodes_[i].within = triangles_around(nodes_[i]);
    while (count_ > 3) {
      std::size_t ear = 0;
      while (ear < count_ && (within(ear + count_ - 1) & within(ear) & within(ear + 1)) == 0) ++ear;
      if (ear == count_) return false;
      for (std::size_t i = ear; i + 1 < count_; ++i) nodes_[i] = nodes_[i + 1];
      --count_;
    }
    return (within(0) & within(1) & within(2)) != 0;
  }

 private:
  struct Node {
    std::uint32_t from = 0;  // A vertex, or an edge, by its ends.
    std::uint32_t to = 0;
    std::uint32_t triangle = kNone;  // Or a triangle.
    std::uint32_t within = 0;        // A bit for each triangle that was met.
  };
  [[nodiscard]] std::uint32_t within(std::size_t i) const {
    return nodes_[i < count_ ? i : i - count_].within;
  }
  [[nodiscard]] std::uint32_t triangles_around(const Node& node) const {
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < met_; ++i) {
      const auto has = [&](std::uint32_t v) {
        const TriangleIndices& t = mesh_.triangle(triangles_[i]);
        return t[0] == v || t[1] == v || t[2] == v;
      };
      const bool is_within = node.triangle != kNone ? node.triangle == triangles_[i]
                                                    : has(node.from) && has(node.to);
      bits |= static_cast<std::uint32_t>(is_within) << i;
    }
    return bits;
  }

  const CollapsingMesh& mesh_;
  std::array<std::uint32_t, 3 * (kMaxCrossings + 1)> triangles_;
  std::size_t met_ = 0;
  std::array<Node, 3 * (kMaxCrossings + 1)> nodes_;
  std::size_t count_ = 0;
};

CarriedSurface::CarriedSurface(const CollapsingMesh& mesh,
                               std::span<const TriangleIndices> original,
                               std::span<const Vec3> positions,
                               std::span<const std::uint8_t> is_anchor)
    : mesh_(mesh),
      original_(original),
      positions_(positions),
      is_anchor_(is_anchor),
      edge_of_(3 * original.size(), kNone),
      around_begin_(positions.size() + 1, 0),
      around_(3 * original.size()),
      carrier_(positions.size(), kNone),
      first_carried_(original.size(), kNone),
      next_carried_(positions.size(), kNone),
      first_passing_(original.size(), kNone),
      seen_triangle_(original.size(), 0) {
  for (const TriangleIndices& t : original) {
    for (const std::uint32_t v : t) ++around_begin_[v + 1];
  }
  for (std::size_t v = 1; v < around_begin_.size(); ++v) around_begin_[v] += around_begin_[v - 1];
  std::vector<std::uint32_t> end(around_begin_.begin(), around_begin_.end() - 1);
  for (std::uint32_t i = 0; i < original.size(); ++i) {
    for (const std::uint32_t v : original[i]) around_[end[v]++] = i;
  }
  ends_.reserve(3 * original.size() / 2 + 8);
  sides_.reserve(3 * original.size() / 2 + 8);
  for (std::uint32_t c = 0; c < edge_of_.size(); ++c) {
    if (edge_of_[c] != kNone) continue;
    const std::uint32_t across = mesh.opposite(c);
    const std::uint32_t p = mesh.vertex(CollapsingMesh::next(c));
    const std::uint32_t q = mesh.vertex(CollapsingMesh::previous(c));
    edge_of_[c] = static_cast<std::uint32_t>(ends_.size());
    if (across != kNone) edge_of_[across] = edge_of_[c];
    ends_.push_back({std::min(p, q), std::max(p, q)});
    sides_.push_back({c / 3, across == kNone ? kNone : across / 3});
  }
  routes_.resize(ends_.size());
  seen_edge_.resize(ends_.size(), 0);
}

double CarriedSurface::bound() const { return std::sqrt(squared_bound_); }

// The triangles around v that were reshaped. One without area carries nothing.
void CarriedSurface::set_up(std::span<const std::uint32_t> ring) {
  fan_.clear();
  apex_ = positions_[mesh_.vertex(ring[1])];
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
    const std::uint32_t c = ring[i];
    fan_.emplace_back();
    NewTriangle& t = fan_.back();
    t.index = c / 3;
    t.edge_first = difference(positions_[mesh_.vertex(CollapsingMesh::next(c))], apex_);
    t.edge_second = difference(positions_[mesh_.vertex(CollapsingMesh::previous(c))], apex_);
    const Vec3 normal = vector_product(t.edge_first, t.edge_second);
    const double squared = squared_length(normal);
    if (!(squared > 0)) {
      fan_.pop_back();
      continue;
    }
    const double scale = 1 / squared;
    t.first = moved({0, 0, 0}, scale, vector_product(t.edge_second, normal));
    t.second = moved({0, 0, 0}, scale, vector_product(normal, t.edge_first));
    t.normal = moved({0, 0, 0}, std::sqrt(scale), normal);
  }
}

// Finds the new triangle that is nearest to the vertex.
bool CarriedSurface::assign(std::uint32_t vertex) {
  const Vec3 p = difference(positions_[vertex], apex_);
  double nearest = squared_limit_;
  std::uint32_t carrier = kNone;
  for (const NewTriangle& t : fan_) {
    const double height = inner_product(p, t.normal);
    const double squared = height * height;
    if (squared > nearest) continue;
    const double s = inner_product(p, t.first);
    const double r = inner_product(p, t.second);
    double distance = squared;
    if (!(s >= 0 && r >= 0 && s + r <= 1)) {
      distance = std::numeric_limits<double>::infinity();
      if (s + r > 1) {
        distance = squared_distance_to_segment(p, t.edge_first,
                                               difference(t.edge_second, t.edge_first));
      }
      if (r < 0) {
        distance = std::min(distance, squared_distance_to_segment(p, {0, 0, 0}, t.edge_first));
      }
      if (s < 0) {
        distance = std::min(distance, squared_distance_to_segment(p, {0, 0, 0}, t.edge_second));
      }
    }
    if (distance < nearest || (distance == nearest && carrier == kNone)) {
      nearest = distance;
      carrier = t.index;
    }
  }
  if (carrier == kNone) return false;
  largest_ = std::max(largest_, nearest);
  carrier_[vertex] = carrier;
  return true;
}

bool CarriedSurface::carry(std::uint32_t u, std::span<const std::uint32_t> ring, double limit) {
  squared_limit_ = limit * limit;
  largest_ = 0;
  ++now_;
  rerouted_.clear();
  cut_.clear();
  touched_.clear();
  touched_.push_back({u, kNone});
  set_up(ring);
  if (!assign(u)) {
    undo();
    ++stats[0];
    return false;
  }
  for (const std::uint32_t corner : ring) {
    for (std::uint32_t p = first_carried_[corner / 3]; p != kNone; p = next_carried_[p]) {
      touched_.push_back({p, corner / 3});
      if (!assign(p)) {
        undo();
        ++stats[1];
        return false;
      }
    }
  }
  gather_edges(ring);
  for (const Rerouted& r : rerouted_) {
    if (!find_route(r.edge)) {
      undo();
      return false;
    }
  }
  for (const std::uint32_t triangle : cut_) {
    if (!is_cut(triangle)) {
      ++stats[4];
      undo();
      return false;
    }
  }
  keep(ring);
  return true;
}

// Edges at touched vertices or through touched triangles, and the triangles at both.
void CarriedSurface::gather_edges(std::span<const std::uint32_t> ring) {
  for (const auto& [vertex, before] : touched_) {
    for (std::uint32_t i = around_begin_[vertex]; i < around_begin_[vertex + 1]; ++i) {
      const std::uint32_t triangle = around_[i];
      const TriangleIndices& t = original_[triangle];
      for (std::uint32_t k = 0; k < 3; ++k) {
        if (t[k] != vertex) gather_edge(edge_of_[3 * triangle + k]);
      }
      if (seen_triangle_[triangle] == now_) continue;
      seen_triangle_[triangle] = now_;
      const std::uint32_t carrier = carrier_[vertex];
      if (carrier_[t[0]] != carrier || carrier_[t[1]] != carrier || carrier_[t[2]] != carrier) {
        cut_.push_back(triangle);
      }
    }
  }
  for (const std::uint32_t corner : ring) {
    for (std::uint32_t i = first_passing_[corner / 3]; i != kNone; i = passing_[i].next) {
      const std::uint32_t edge = passing_[i].edge;
      gather_edge(edge);
      for (const std::uint32_t triangle : sides_[edge]) {
        if (triangle == kNone || seen_triangle_[triangle] == now_) continue;
        seen_triangle_[triangle] = now_;
        cut_.push_back(triangle);
      }
    }
  }
}

void CarriedSurface::gather_edge(std::uint32_t edge) {
  if (seen_edge_[edge] == now_) return;
  seen_edge_[edge] = now_;
  rerouted_.push_back({edge, routes_[edge]});
}

// A triangle that the lower end's image lies in, if there is but one.
bool CarriedSurface::find_route(std::uint32_t edge) {
  const Ends& ends = ends_[edge];
  Route& route = routes_[edge];
  route = {};
  const std::uint32_t from = carrier_[ends.low];
  const std::uint32_t to = carrier_[ends.high];
  if (from == to) return true;
  const std::uint32_t carrier = from == kNone ? to : from;
  const std::uint32_t other = from == kNone ? ends.low : ends.high;
  const bool stays = from == kNone || to == kNone;
  if (stays && holds(carrier, other)) return true;
  Crossings best;
  best.count = kMaxCrossings + 1;
  for (const std::uint32_t pivot : mesh_.triangle(carrier)) {
    if (!stays && !holds(to, pivot)) continue;
    for (const bool forwards : {true, false}) {
      const Route candidate = {pivot, forwards};
      Crossings crossings;
      if (follow(ends, candidate, crossings) && crossings.count < best.count) {
        best = crossings;
        route = candidate;
      }
    }
    if (best.count == 1) break;
  }
  if (best.count > kMaxCrossings) {
    ++stats[5];
    return false;
  }
  return is_within_limit(ends, best);
}

// Goes around the pivot from the carrier of one end to the other end; false when it does not get
// there. Where only one end is carried, it starts there.
bool CarriedSurface::follow(const Ends& ends, const Route& route, Crossings& crossings) const {
  const std::uint32_t from = carrier_[ends.low];
  const std::uint32_t to = carrier_[ends.high];
  const std::uint32_t start = from == kNone ? to : from;
  const TriangleIndices& t = mesh_.triangle(start);
  std::uint32_t at = 3 * start + (t[0] == route.pivot ? 0 : t[1] == route.pivot ? 1 : 2);
  while (crossings.count < kMaxCrossings) {
    const std::uint32_t facing =
        route.forwards ? CollapsingMesh::next(at) : CollapsingMesh::previous(at);
    const std::uint32_t across = mesh_.opposite(facing);
    if (across == kNone || is_anchor_[across / 3] != 0) return false;
    crossings.corners[crossings.count++] = facing;
    at = route.forwards ? CollapsingMesh::next(across) : CollapsingMesh::previous(across);
    const bool is_there = from == kNone   ? mesh_.vertex(across) == ends.low
                          : to == kNone ? mesh_.vertex(across) == ends.high
                                          : across / 3 == to;
    if (is_there) return true;
    if (across / 3 == start) return false;
  }
  return false;
}

bool CarriedSurface::is_within_limit(const Ends& ends, const Crossings& crossings) {
  // From where the crossings begin.
  const bool from_low = carrier_[ends.low] != kNone;
  const Vec3& p = positions_[from_low ? ends.low : ends.high];
  const Vec3 pq = difference(positions_[from_low ? ends.high : ends.low], p);
  double part = 0;
  for (std::size_t i = 0; i < crossings.count; ++i) {
    const std::uint32_t corner = crossings.corners[i];
    const Vec3& begin = positions_[mesh_.vertex(CollapsingMesh::next(corner))];
    const Vec3 along =
        difference(positions_[mesh_.vertex(CollapsingMesh::previous(corner))], begin);
    const NearestParts nearest = nearest_parts(p, pq, begin, along);
    double squared = nearest.squared_distance;
    if (nearest.s < part) {
      squared = squared_distance_to_segment(moved(p, part, pq), begin, along);
    } else {
      part = nearest.s;
    }
    if (squared > squared_limit_) {
      ++stats[2];
      return false;
    }
    largest_ = std::max(largest_, squared);
  }
  return true;
}

bool CarriedSurface::is_cut(std::uint32_t original_triangle) {
  const TriangleIndices& t = original_[original_triangle];
  Outline outline(mesh_);
  for (std::uint32_t i = 0; i < 3; ++i) {
    if (carrier_[t[i]] != kNone) outline.meet(carrier_[t[i]]);
  }
  for (std::uint32_t i = 0; i < 3; ++i) {
    const std::uint32_t v = t[i];
    carrier_[v] == kNone ? outline.add_vertex(v) : outline.add_carried(carrier_[v]);
    // The edge to the next corner lies opposite to the one after.
    const std::uint32_t edge = edge_of_[3 * original_triangle + (i + 2) % 3];
    const Route& route = routes_[edge];
    if (route.pivot == kNone) continue;
    Crossings crossings;
    const bool found = follow(ends_[edge], route, crossings);
    assert(found);
    if (!found) return false;
    const bool from_low = carrier_[ends_[edge].low] != kNone;
    const bool same_way = (ends_[edge].low == v) == from_low;
    for (std::size_t k = 0; k < crossings.count; ++k) {
      const std::uint32_t corner =
          crossings.corners[same_way ? k : crossings.count - 1 - k];
      outline.meet(corner / 3);
      outline.meet(mesh_.opposite(corner) / 3);
      outline.add_crossing(mesh_.vertex(CollapsingMesh::next(corner)),
                           mesh_.vertex(CollapsingMesh::previous(corner)));
    }
  }
  return outline.is_cut_into_triangles();
}

void CarriedSurface::keep(std::span<const std::uint32_t> ring) {
  for (const std::uint32_t corner : ring) {
    first_carried_[corner / 3] = kNone;
    first_passing_[corner / 3] = kNone;
  }
  for (const auto& [vertex, before] : touched_) {
    std::uint32_t& first = first_carried_[carrier_[vertex]];
    next_carried_[vertex] = first;
    first = vertex;
  }
  for (const Rerouted& r : rerouted_) {
    const Route& route = routes_[r.edge];
    if (route.pivot == kNone) continue;
    Crossings crossings;
    (void)follow(ends_[r.edge], route, crossings);
    for (std::size_t k = 1; k < crossings.count; ++k) {
      std::uint32_t& first = first_passing_[crossings.corners[k] / 3];
      passing_.push_back({r.edge, first});
      first = static_cast<std::uint32_t>(passing_.size() - 1);
    }
    if (carrier_[ends_[r.edge].low] != kNone && carrier_[ends_[r.edge].high] != kNone) continue;
    std::uint32_t& first =
        first_passing_[mesh_.opposite(crossings.corners[crossings.count - 1]) / 3];
    passing_.push_back({r.edge, first});
    first = static_cast<std::uint32_t>(passing_.size() - 1);
  }
  squared_bound_ = std::max(squared_bound_, largest_);
}

void CarriedSurface::undo() {
  for (const auto& [vertex, before] : touched_) carrier_[vertex] = before;
  for (const Rerouted& r : rerouted_) routes_[r.edge] = r.before;
}

}  // namespace multitetra
