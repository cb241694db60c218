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
      const bool is_within =
          node.triangle != kNone ? node.triangle == triangles_[i] : has(node.from) && has(node.to);
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
      spokes_begin_(positions.size() + 1, 0),
      carrier_(positions.size(), kNone),
      first_carried_(original.size(), kNone),
      next_carried_(positions.size(), kNone),
      first_passing_(original.size(), kNone),
      seen_triangle_(original.size(), 0) {
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
  for (const Ends& e : ends_) {
    ++spokes_begin_[e.low + 1];
    ++spokes_begin_[e.high + 1];
  }
  for (std::size_t v = 1; v < spokes_begin_.size(); ++v) spokes_begin_[v] += spokes_begin_[v - 1];
  std::vector<std::uint32_t> end(spokes_begin_.begin(), spokes_begin_.end() - 1);
  spokes_.resize(2 * ends_.size());
  for (std::uint32_t i = 0; i < ends_.size(); ++i) {
    spokes_[end[ends_[i].low]++] = {i, ends_[i].high};
    spokes_[end[ends_[i].high]++] = {i, ends_[i].low};
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
        distance =
            squared_distance_to_segment(p, t.edge_first, difference(t.edge_second, t.edge_first));
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
    return false;
  }
  for (const std::uint32_t corner : ring) {
    for (std::uint32_t p = first_carried_[corner / 3]; p != kNone; p = next_carried_[p]) {
      touched_.push_back({p, corner / 3});
      if (!assign(p)) {
        undo();
        return false;
      }
    }
  }
  if (!reroute(ring)) {
    undo();
    return false;
  }
  for (const std::uint32_t triangle : cut_) {
    if (!is_cut(triangle)) {
      undo();
      return false;
    }
  }
  keep(ring);
  return true;
}

// Finds routes for the edges at touched vertices and for those that pass touched triangles.
bool CarriedSurface::reroute(std::span<const std::uint32_t> ring) {
  const std::uint32_t apex = mesh_.vertex(ring[1]);
  for (const auto& [vertex, before] : touched_) {
    const std::uint32_t carrier = carrier_[vertex];
    for (std::uint32_t i = spokes_begin_[vertex]; i < spokes_begin_[vertex + 1]; ++i) {
      const auto& [edge, other] = spokes_[i];
      if (carrier_[other] == carrier && routes_[edge].pivot == kNone) continue;
      if (!reroute(edge, apex)) return false;
    }
  }
  for (const std::uint32_t corner : ring) {
    for (std::uint32_t i = first_passing_[corner / 3]; i != kNone; i = passing_[i].next) {
      if (!reroute(passing_[i].edge, apex)) return false;
    }
  }
  return true;
}

bool CarriedSurface::reroute(std::uint32_t edge, std::uint32_t preferred_pivot) {
  if (seen_edge_[edge] == now_) return true;
  seen_edge_[edge] = now_;
  const Ends& ends = ends_[edge];
  Route& route = routes_[edge];
  const Route before = route;
  const std::uint32_t from = carrier_[ends.low];
  const std::uint32_t to = carrier_[ends.high];
  const bool is_within_one = from == to || (from == kNone && holds(to, ends.low)) ||
                             (to == kNone && holds(from, ends.high));
  if (is_within_one) {
    if (before.pivot == kNone) return true;
    rerouted_.push_back({edge, before});
    route = {};
    return true;
  }
  rerouted_.push_back({edge, before});
  route = shortest_route(ends, preferred_pivot);
  if (route.pivot == kNone) {
    return false;
  }
  if (!is_within_limit(ends, route)) {
    return false;
  }
  for (const std::uint32_t triangle : sides_[edge]) {
    if (triangle == kNone || seen_triangle_[triangle] == now_) continue;
    seen_triangle_[triangle] = now_;
    cut_.push_back(triangle);
  }
  return true;
}

// Without a pivot when there is none of at most kMaxTurns.
CarriedSurface::Route CarriedSurface::shortest_route(const Ends& ends,
                                                     std::uint32_t preferred_pivot) const {
  const std::uint32_t from = carrier_[ends.low];
  const std::uint32_t to = carrier_[ends.high];
  const std::uint32_t start = from == kNone ? to : from;
  const bool both = from != kNone && to != kNone;
  Route route;
  std::int32_t most = kMaxTurns;
  const auto try_pivot = [&](std::uint32_t pivot) {
    if (both && !holds(to, pivot)) return;
    if (const std::int32_t turns = turns_around(ends, pivot, most); turns != 0) {
      route = {pivot, turns};
      most = std::abs(turns) - 1;
    }
  };
  const bool has_preferred = holds(start, preferred_pivot);
  if (has_preferred) try_pivot(preferred_pivot);
  for (const std::uint32_t pivot : mesh_.triangle(start)) {
    if (most == 0) break;
    if (pivot != preferred_pivot) try_pivot(pivot);
  }
  return route;
}

// How many edges are crossed on the shorter way around the pivot; 0 when more than `most`.
std::int32_t CarriedSurface::turns_around(const Ends& ends, std::uint32_t pivot,
                                          std::int32_t most) const {
  const std::uint32_t from = carrier_[ends.low];
  const std::uint32_t to = carrier_[ends.high];
  const std::uint32_t start = from == kNone ? to : from;
  const std::uint32_t goal = from == kNone ? ends.low : ends.high;
  const bool both = from != kNone && to != kNone;
  const TriangleIndices& t = mesh_.triangle(start);
  std::uint32_t forwards = 3 * start + (t[0] == pivot ? 0 : t[1] == pivot ? 1 : 2);
  std::uint32_t backwards = forwards;
  for (std::int32_t turns = 1; turns <= most; ++turns) {
    if (forwards != kNone) {
      const std::uint32_t across = mesh_.opposite(CollapsingMesh::next(forwards));
      if (across == kNone || is_anchor_[across / 3] != 0) {
        forwards = kNone;
      } else if (both ? across / 3 == to : mesh_.vertex(across) == goal) {
        return turns;
      } else {
        forwards = CollapsingMesh::next(across);
      }
    }
    if (backwards != kNone) {
      const std::uint32_t across = mesh_.opposite(CollapsingMesh::previous(backwards));
      if (across == kNone || is_anchor_[across / 3] != 0) {
        backwards = kNone;
      } else if (both ? across / 3 == to : mesh_.vertex(across) == goal) {
        return -turns;
      } else {
        backwards = CollapsingMesh::previous(across);
      }
    }
  }
  return 0;
}

void CarriedSurface::follow(const Ends& ends, const Route& route, Crossings& crossings) const {
  const std::uint32_t from = carrier_[ends.low];
  const std::uint32_t start = from == kNone ? carrier_[ends.high] : from;
  const TriangleIndices& t = mesh_.triangle(start);
  const bool forwards = route.turns > 0;
  crossings.count = static_cast<std::size_t>(std::abs(route.turns));
  std::uint32_t at = 3 * start + (t[0] == route.pivot ? 0 : t[1] == route.pivot ? 1 : 2);
  for (std::size_t i = 0; i < crossings.count; ++i) {
    const std::uint32_t facing = forwards ? CollapsingMesh::next(at) : CollapsingMesh::previous(at);
    const std::uint32_t across = mesh_.opposite(facing);
    assert(across != kNone);
    crossings.corners[i] = facing;
    at = forwards ? CollapsingMesh::next(across) : CollapsingMesh::previous(across);
  }
}

bool CarriedSurface::is_within_limit(const Ends& ends, const Route& route) {
  Crossings crossings;
  follow(ends, route, crossings);
  const bool from_low = carrier_[ends.low] != kNone;
  const Vec3& p = positions_[from_low ? ends.low : ends.high];
  const Vec3 pq = difference(positions_[from_low ? ends.high : ends.low], p);
  const Vec3& pivot = positions_[route.pivot];
  double part = 0;
  for (std::size_t i = 0; i < crossings.count; ++i) {
    // The crossed edge ends in the pivot.
    const std::uint32_t corner = crossings.corners[i];
    const std::uint32_t end = mesh_.vertex(route.turns > 0 ? CollapsingMesh::next(corner)
                                                           : CollapsingMesh::previous(corner));
    const Vec3 along = difference(positions_[end], pivot);
    const NearestParts nearest = nearest_parts(p, pq, pivot, along);
    double squared = nearest.squared_distance;
    if (nearest.s < part) {
      squared = squared_distance_to_segment(moved(p, part, pq), pivot, along);
    } else {
      part = nearest.s;
    }
    if (squared > squared_limit_) return false;
    largest_ = std::max(largest_, squared);
  }
  return true;
}

// Whether all goes on around one pivot, without going around it. Then chords need no search: they
// cut the triangle along the edges at the pivot, in their order.
//
// Where the images of the corners are, counted in triangles around the pivot, adds up to a multiple
// of its valence on the way around the outline. Routes tell that sum but for half a triangle at
// each of the two edges at a corner that stays.
bool CarriedSurface::is_cut_around_a_pivot(std::uint32_t original_triangle) const {
  const TriangleIndices& t = original_[original_triangle];
  int stay = 0;
  int routes = 0;
  std::uint32_t pivot = kNone;
  std::uint32_t facing = kNone;
  std::int32_t sum = 0;
  for (std::uint32_t i = 0; i < 3; ++i) {
    const std::uint32_t v = t[i];
    if (carrier_[v] == kNone) ++stay;
    const std::uint32_t edge = edge_of_[3 * original_triangle + (i + 2) % 3];
    const Route& route = routes_[edge];
    if (route.pivot == kNone) continue;
    if (pivot != kNone && route.pivot != pivot) return false;
    ++routes;
    pivot = route.pivot;
    facing = t[(i + 2) % 3];
    const bool from_low = carrier_[ends_[edge].low] != kNone;
    sum += (ends_[edge].low == v) == from_low ? route.turns : -route.turns;
  }
  // Chords from a corner that is the pivot to all crossings of the edge that it faces.
  if (routes == 1 && facing == pivot) return true;
  return stay <= 1 && static_cast<std::uint32_t>(std::abs(sum) + stay) < mesh_.valence(pivot);
}

bool CarriedSurface::is_cut(std::uint32_t original_triangle) const {
  if (is_cut_around_a_pivot(original_triangle)) return true;
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
    follow(ends_[edge], route, crossings);
    const bool from_low = carrier_[ends_[edge].low] != kNone;
    const bool same_way = (ends_[edge].low == v) == from_low;
    for (std::size_t k = 0; k < crossings.count; ++k) {
      const std::uint32_t corner = crossings.corners[same_way ? k : crossings.count - 1 - k];
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
    const Ends& ends = ends_[r.edge];
    const bool both = carrier_[ends.low] != kNone && carrier_[ends.high] != kNone;
    if (route.pivot == kNone || (both && std::abs(route.turns) == 1)) continue;
    Crossings crossings;
    follow(ends, route, crossings);
    for (std::size_t k = 1; k < crossings.count; ++k) pass(r.edge, crossings.corners[k] / 3);
    if (!both) pass(r.edge, mesh_.opposite(crossings.corners[crossings.count - 1]) / 3);
  }
  squared_bound_ = std::max(squared_bound_, largest_);
}

void CarriedSurface::pass(std::uint32_t edge, std::uint32_t triangle) {
  passing_.push_back({edge, first_passing_[triangle]});
  first_passing_[triangle] = static_cast<std::uint32_t>(passing_.size() - 1);
}

void CarriedSurface::undo() {
  for (const auto& [vertex, before] : touched_) carrier_[vertex] = before;
  for (const Rerouted& r : rerouted_) routes_[r.edge] = r.before;
}

}  // namespace multitetra
