#include "server/certify/detail/component_partners.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/mesh/box_tree.hpp"

namespace multitetra {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// Returns the triangles of the components for which `is_wanted(component)`.
template <typename IsWanted>
std::vector<SurfaceTriangle> triangles_where(const SurfaceParts& surface, const IsWanted& is_wanted,
                                             std::vector<std::uint32_t>* owners = nullptr) {
  std::vector<SurfaceTriangle> triangles;
  for (const TriangleIndices& t : surface.mesh.triangles) {
    const std::uint32_t component = surface.components.of_vertex[t[0]];
    if (!is_wanted(component)) continue;
    const auto& vertices = surface.mesh.vertices;
    triangles.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
    if (owners != nullptr) owners->push_back(component);
  }
  return triangles;
}

// Returns up to kSamples vertices of each component, evenly spread over their numbers.
std::vector<std::vector<std::uint32_t>> sampled_vertices(const SurfaceParts& surface) {
  constexpr std::size_t kSamples = 64;
  std::vector<std::size_t> count(surface.facings.size(), 0);
  for (const std::uint32_t component : surface.components.of_vertex) ++count[component];
  std::vector<std::size_t> seen(count.size(), 0);
  std::vector<std::vector<std::uint32_t>> sampled(count.size());
  for (std::uint32_t v = 0; v < surface.components.of_vertex.size(); ++v) {
    const std::uint32_t component = surface.components.of_vertex[v];
    const std::size_t step = 1 + count[component] / kSamples;
    if (seen[component]++ % step == 0) sampled[component].push_back(v);
  }
  return sampled;
}

std::vector<std::uint32_t> first_vertices(const SurfaceParts& surface) {
  std::vector<std::uint32_t> first(surface.facings.size(), kNone);
  for (std::uint32_t v = 0; v < surface.components.of_vertex.size(); ++v) {
    std::uint32_t& one = first[surface.components.of_vertex[v]];
    if (one == kNone) one = v;
  }
  return first;
}

// ---- orientation

bool is_closed(Facing facing) { return facing == Facing::kInwards || facing == Facing::kOutwards; }

std::int64_t count_of(const SurfaceParts& surface, Facing facing) {
  return std::count(surface.facings.begin(), surface.facings.end(), facing);
}

// Whether closed components have closed counterparts: as many of all, and of open ones.
bool are_counterparts_closed(const SurfaceParts& one, const SurfaceParts& other) {
  return one.facings.size() == other.facings.size() &&
         count_of(one, Facing::kOpen) == count_of(other, Facing::kOpen);
}

// Returns how many closed components of `one` have none of `other` left that may face the same way.
std::int64_t without_counterpart(const SurfaceParts& one, const SurfaceParts& other) {
  std::int64_t most = 0;
  for (const Facing facing : {Facing::kInwards, Facing::kOutwards}) {
    const std::int64_t possible = count_of(other, facing) + count_of(other, Facing::kUnknown);
    most = std::max(most, count_of(one, facing) - possible);
  }
  return most;
}

// Sets `is_faulty` for the closed components of `one` with a vertex farther than `allowed` from the
// components of `other` that face the same way or whose orientation is unknown; these include open
// ones unless closed components have closed counterparts.
void find_reversed(const SurfaceParts& one, const SurfaceParts& other, double allowed,
                   std::vector<char>& is_faulty) {
  const bool may_be_open = !are_counterparts_closed(one, other);
  for (const Facing facing : {Facing::kInwards, Facing::kOutwards}) {
    if (std::find(one.facings.begin(), one.facings.end(), facing) == one.facings.end()) continue;
    const NearestTriangle same(triangles_where(other, [&](std::uint32_t i) {
      return other.facings[i] == facing || other.facings[i] == Facing::kUnknown ||
             (may_be_open && other.facings[i] == Facing::kOpen);
    }));
    std::vector<char> is_far(one.mesh.vertices.size(), 0);
    in_parallel(is_far.size(), [&](std::size_t v) {
      if (one.facings[one.components.of_vertex[v]] != facing) return;
      is_far[v] = same.distance(one.mesh.vertices[v]) > allowed ? 1 : 0;
    });
    for (std::size_t v = 0; v < is_far.size(); ++v) {
      if (is_far[v] != 0) is_faulty[one.components.of_vertex[v]] = 1;
    }
  }
}

// Sets `is_faulty` for the open components whose normals are opposite to those of the full surface.
void find_reversed_sheets(const SurfaceParts& mesh, const SurfaceParts& full,
                          std::vector<char>& is_faulty) {
  constexpr std::size_t kSamples = 256;
  std::map<std::uint32_t, std::vector<SurfaceTriangle>> sheets;
  std::vector<std::uint32_t> owners;
  const auto is_open = [&](std::uint32_t i) { return !is_closed(mesh.facings[i]); };
  const std::vector<SurfaceTriangle> all = triangles_where(mesh, is_open, &owners);
  if (all.empty()) return;
  for (std::size_t i = 0; i < all.size(); ++i) sheets[owners[i]].push_back(all[i]);
  const NearestTriangle nearest(triangles_of(full.mesh));
  const auto area_vector = [](const SurfaceTriangle& t) {
    return cross(difference(t[1], t[0]), difference(t[2], t[0]));
  };
  for (const auto& [component, triangles] : sheets) {
    const std::size_t step = 1 + triangles.size() / kSamples;
    double agreeing = 0;
    double area = 0;
    for (std::size_t i = 0; i < triangles.size(); i += step) {
      const Vec3 own = area_vector(triangles[i]);
      const Vec3 middle =
          scaled(sum(sum(triangles[i][0], triangles[i][1]), triangles[i][2]), 1.0 / 3);
      const auto found = nearest.nearest(middle);
      if (found.triangle == nullptr) continue;
      const Vec3 there = area_vector(*found.triangle);
      const double length_there = length(there);
      if (length_there > 0) agreeing += dot(own, there) / length_there;
      area += length(own);
    }
    if (agreeing < -0.5 * area) is_faulty[component] = 1;
  }
}

// ---- sides

// Finds the closed components around a point, by the crossings of a ray along x.
class Enclosures {
 public:
  template <typename IsWanted>
  Enclosures(const SurfaceParts& surface, const IsWanted& is_wanted)
      : triangles_(triangles_where(surface, is_wanted, &owners_)), tree_(boxes_of(triangles_)) {}

  // Returns the components, except `own`, sorted.
  [[nodiscard]] std::vector<std::uint32_t> around(const Vec3& point, std::uint32_t own) const {
    std::map<std::uint32_t, bool> is_inside;
    Box3 ray;
    ray.add(point);
    ray.high[0] = std::numeric_limits<double>::infinity();
    tree_.visit_near(ray, [&](std::uint32_t place) {
      const std::uint32_t triangle = tree_.order()[place];
      if (owners_[triangle] != own && is_crossed(triangles_[triangle], point)) {
        is_inside[owners_[triangle]] ^= true;
      }
    });
    std::vector<std::uint32_t> components;
    for (const auto& [component, is_in] : is_inside) {
      if (is_in) components.push_back(component);
    }
    return components;
  }

 private:
  static std::vector<Box3> boxes_of(const std::vector<SurfaceTriangle>& triangles) {
    std::vector<Box3> boxes(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      for (const Vec3& corner : triangles[i]) boxes[i].add(corner);
    }
    return boxes;
  }
  // Returns whether the point is left of a -> b along y and z. A point on the line counts as moved
  // by (e, e^2) for an infinitely small e, so a shared edge has one answer for both triangles.
  static bool is_left(const Vec3& a, const Vec3& b, const Vec3& point) {
    if (b < a) return !is_left(b, a, point);
    const double side = (b[1] - a[1]) * (point[2] - a[2]) - (b[2] - a[2]) * (point[1] - a[1]);
    if (side != 0) return side > 0;
    return a[2] != b[2] ? b[2] < a[2] : b[1] > a[1];
  }
  static bool is_crossed(const SurfaceTriangle& t, const Vec3& point) {
    const bool side = is_left(t[0], t[1], point);
    if (is_left(t[1], t[2], point) != side || is_left(t[2], t[0], point) != side) return false;
    const Vec3 normal = cross(difference(t[1], t[0]), difference(t[2], t[0]));
    const Vec3 from = difference(t[0], point);
    return normal[0] != 0 && dot(normal, from) / normal[0] > 0;
  }

  std::vector<std::uint32_t> owners_;  // Of the triangles.
  std::vector<SurfaceTriangle> triangles_;
  BoxTree tree_;
};

// Returns for each large component of the mesh the component of the full surface that most of its
// vertices are nearest to; kNone for small ones and for those that are not alone there.
std::vector<std::uint32_t> partners(const SurfaceParts& mesh, const SurfaceParts& full,
                                    const std::vector<std::vector<std::uint32_t>>& vertices,
                                    const std::vector<char>& is_large) {
  std::vector<std::uint32_t> partner(mesh.facings.size(), kNone);
  for (const Facing facing : {Facing::kInwards, Facing::kOutwards}) {
    std::vector<std::uint32_t> owners;
    const std::vector<SurfaceTriangle> triangles = triangles_where(
        full, [&](std::uint32_t i) { return full.facings[i] == facing; }, &owners);
    if (triangles.empty()) continue;
    const NearestTriangle nearest(triangles);
    for (std::uint32_t i = 0; i < vertices.size(); ++i) {
      if (is_large[i] == 0 || mesh.facings[i] != facing) continue;
      std::map<std::uint32_t, std::size_t> votes;
      for (const std::uint32_t v : vertices[i]) {
        ++votes[owners[nearest.nearest(mesh.mesh.vertices[v]).index]];
      }
      partner[i] = std::max_element(votes.begin(), votes.end(), [](auto& a, auto& b) {
                     return a.second < b.second;
                   })->first;
    }
  }
  std::map<std::uint32_t, std::size_t> uses;
  for (const std::uint32_t one : partner) ++uses[one];
  for (std::uint32_t& one : partner) {
    if (one != kNone && uses[one] > 1) one = kNone;
  }
  return partner;
}

// Sets `is_faulty` for components that lie inside other large components than any component of the
// full surface that may be theirs.
void find_misplaced(const SurfaceParts& mesh, const SurfaceParts& full, double allowed,
                    double voxel, std::vector<char>& is_faulty) {
  const double steps = allowed / voxel;
  std::vector<char> is_large(mesh.facings.size(), 0);
  for (std::size_t i = 0; i < is_large.size(); ++i) {
    is_large[i] = is_closed(mesh.facings[i]) && mesh.components.diagonals[i] >= 8 * steps;
  }
  const std::vector<std::vector<std::uint32_t>> vertices = sampled_vertices(mesh);
  const std::vector<std::uint32_t> partner = partners(mesh, full, vertices, is_large);
  std::vector<std::uint32_t> back(full.facings.size(), kNone);
  for (std::uint32_t i = 0; i < partner.size(); ++i) {
    if (partner[i] != kNone) back[partner[i]] = i;
  }
  const Enclosures of_mesh(mesh, [&](std::uint32_t i) { return partner[i] != kNone; });
  const Enclosures of_full(full, [&](std::uint32_t i) { return back[i] != kNone; });
  // Around each component of the full surface, in the numbers of the mesh.
  const std::vector<std::uint32_t> full_vertex = first_vertices(full);
  std::vector<std::vector<std::uint32_t>> around_full(full.facings.size());
  std::vector<Box3> boxes(full.facings.size());
  for (std::size_t v = 0; v < full.mesh.vertices.size(); ++v) {
    boxes[full.components.of_vertex[v]].add(full.mesh.vertices[v]);
  }
  in_parallel(around_full.size(), [&](std::size_t j) {
    const auto own = static_cast<std::uint32_t>(j);
    for (const std::uint32_t one : of_full.around(full.mesh.vertices[full_vertex[j]], own)) {
      around_full[j].push_back(back[one]);
    }
    std::sort(around_full[j].begin(), around_full[j].end());
  });
  const BoxTree tree(boxes);
  // Returns whether the vertex lies inside the same components as one that may be its counterpart,
  // or there is none.
  const auto fits = [&](std::uint32_t i, std::uint32_t v) {
    const Vec3& point = mesh.mesh.vertices[v];
    const auto around = of_mesh.around(point, i);
    if (partner[i] != kNone) return around_full[partner[i]] == around;
    Box3 near;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      near.low[axis] = point[axis] - allowed;
      near.high[axis] = point[axis] + allowed;
    }
    bool has_candidate = false;
    bool has_equal = false;
    tree.visit_near(near, [&](std::uint32_t place) {
      const std::uint32_t j = tree.order()[place];
      const double change = full.components.diagonals[j] - mesh.components.diagonals[i];
      const bool is_similar = std::abs(change) <= 4 * steps && full.facings[j] == mesh.facings[i];
      if (!is_similar || !boxes[j].touches(near)) return;
      has_candidate = true;
      has_equal = has_equal || around_full[j] == around;
    });
    return has_equal || !has_candidate;
  };
  in_parallel(mesh.facings.size(), [&](std::size_t i) {
    // The error may carry a smaller one through a wall.
    if (mesh.components.diagonals[i] < 2 * steps) return;
    const auto component = static_cast<std::uint32_t>(i);
    is_faulty[i] = std::none_of(vertices[i].begin(), vertices[i].end(),
                                [&](std::uint32_t v) { return fits(component, v); });
  });
}

std::optional<Vec3> place_of_first(const SurfaceParts& surface,
                                   const std::vector<char>& is_faulty) {
  const auto first = std::find(is_faulty.begin(), is_faulty.end(), 1);
  if (first == is_faulty.end()) return std::nullopt;
  return surface.mesh
      .vertices[first_vertices(surface)[static_cast<std::size_t>(first - is_faulty.begin())]];
}

}  // namespace

ComponentFaults compared_components(const SurfaceParts& mesh, const SurfaceParts& full,
                                    double allowed, double voxel) {
  std::vector<char> reversed(mesh.facings.size(), 0);
  find_reversed(mesh, full, allowed, reversed);
  find_reversed_sheets(mesh, full, reversed);
  std::vector<char> unmatched(full.facings.size(), 0);
  find_reversed(full, mesh, allowed, unmatched);
  const auto count = [](const std::vector<char>& faults) {
    return static_cast<std::uint64_t>(std::count(faults.begin(), faults.end(), 1));
  };
  ComponentFaults faults{.reversed = std::max(count(reversed), count(unmatched)),
                         .place = place_of_first(mesh, reversed)};
  faults.are_all_reversed = !reversed.empty() && count(reversed) == reversed.size();
  if (!faults.place) faults.place = place_of_first(full, unmatched);
  if (are_counterparts_closed(mesh, full)) {
    const std::int64_t surplus =
        std::max(without_counterpart(mesh, full), without_counterpart(full, mesh));
    faults.reversed = std::max(faults.reversed, static_cast<std::uint64_t>(surplus));
  }
  if (faults.reversed > 0) return faults;
  std::vector<char> misplaced(mesh.facings.size(), 0);
  find_misplaced(mesh, full, allowed, voxel, misplaced);
  faults.misplaced = count(misplaced);
  faults.place = place_of_first(mesh, misplaced);
  return faults;
}

}  // namespace multitetra
