#include "server/core/compaction.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "server/core/carried_surface.hpp"
#include "server/core/collapsing_mesh.hpp"
#include "server/core/quadric.hpp"
#include "server/core/vectors.hpp"

namespace multitetra {
namespace {

constexpr std::uint32_t kNone = CollapsingMesh::kNone;

// Relative to one of the vertices: large coordinates would cost precision.
std::vector<Vec3> positions_of(const LatticeMesh& mesh, const Vec3& step) {
  std::vector<Vec3> positions;
  positions.reserve(mesh.vertices.size());
  for (const LatticePoint& p : mesh.vertices) {
    const LatticePoint& o = mesh.vertices.front();
    positions.push_back({step[0] * (p.x - o.x), step[1] * (p.y - o.y), step[2] * (p.z - o.z)});
  }
  return positions;
}

Vec3 normal_of(const Vec3& p, const Vec3& q, const Vec3& r) {
  return vector_product(difference(q, p), difference(r, p));
}

// The largest triangle of every component without border.
std::vector<std::uint8_t> anchors(const CollapsingMesh& mesh, const std::vector<Vec3>& positions) {
  std::vector<std::uint8_t> is_anchor(mesh.triangle_count(), 0);
  std::vector<std::uint8_t> is_seen(mesh.triangle_count(), 0);
  std::vector<std::uint32_t> component;
  for (std::uint32_t start = 0; start < mesh.triangle_count(); ++start) {
    if (is_seen[start] != 0) continue;
    component.assign(1, start);
    is_seen[start] = 1;
    bool has_border = false;
    double largest = -1;
    std::uint32_t anchor = start;
    for (std::size_t i = 0; i < component.size(); ++i) {
      const std::uint32_t triangle = component[i];
      for (std::uint32_t corner = 3 * triangle; corner < 3 * triangle + 3; ++corner) {
        const std::uint32_t across = mesh.opposite(corner);
        if (across == kNone) {
          has_border = true;
        } else if (is_seen[across / 3] == 0) {
          is_seen[across / 3] = 1;
          component.push_back(across / 3);
        }
      }
      const auto& [p, q, r] = mesh.triangle(triangle);
      const double size = squared_length(normal_of(positions[p], positions[q], positions[r]));
      if (size > largest || (size == largest && triangle < anchor)) {
        largest = size;
        anchor = triangle;
      }
    }
    if (!has_border) is_anchor[anchor] = 1;
  }
  return is_anchor;
}

class Compaction {
 public:
  Compaction(const LatticeMesh& mesh, const CompactionOptions& options)
      : input_(mesh),
        budget_(options.budget),
        positions_(positions_of(mesh, options.step)),
        mesh_(mesh.triangles, static_cast<std::uint32_t>(mesh.vertices.size())),
        is_anchor_(anchors(mesh_, positions_)),
        carried_(mesh_, mesh.triangles, positions_, is_anchor_),
        quadrics_(positions_.size()),
        is_closed_(positions_.size(), 0),
        refusals_(positions_.size(), 0),
        is_stale_(positions_.size(), 1),
        least_cost_(positions_.size(), 0) {
    std::vector<std::uint8_t> stays(positions_.size(), 0);
    for (std::uint32_t i = 0; i < mesh_.triangle_count(); ++i) {
      const TriangleIndices& t = mesh_.triangle(i);
      const Quadric quadric =
          Quadric::of_triangle(positions_[t[0]], positions_[t[1]], positions_[t[2]]);
      for (const std::uint32_t v : t) {
        quadrics_[v].add(quadric);
        if (is_anchor_[i] != 0) stays[v] = 1;
      }
    }
    for (std::uint32_t v = 0; v < stays.size(); ++v) {
      if (stays[v] == 0 && mesh_.kind(v) == CollapsingMesh::VertexKind::kInner) open_.push_back(v);
    }
  }

  Compacted run() {
    for (int pass = 0; pass < kPasses && choose_candidates(); ++pass) {
      for (const std::uint32_t v : candidates_) try_vertex(v);
    }
    return result();
  }

 private:
  static constexpr int kPasses = 16;
  static constexpr int kTries = 2;
  static constexpr std::uint8_t kRefusals = 4;

  struct Target {
    double cost = 0;
    std::uint32_t corner = 0;
    friend auto operator<=>(const Target&, const Target&) = default;
  };

  // The cheaper half of the vertices that may move, in the order of their numbers: neighbours are
  // near to each other in memory.
  bool choose_candidates() {
    costs_.clear();
    std::size_t kept = 0;
    for (const std::uint32_t v : open_) {
      if (carried_.is_carried(v)) continue;
      open_[kept++] = v;
      if (is_closed_[v] != 0) continue;
      if (is_stale_[v] != 0) {
        least_cost_[v] = least_cost(v);
        is_stale_[v] = 0;
      }
      costs_.push_back(least_cost_[v]);
    }
    open_.resize(kept);
    candidates_.clear();
    if (costs_.empty()) return false;
    const auto middle = costs_.begin() + static_cast<std::ptrdiff_t>(costs_.size() / 2);
    std::nth_element(costs_.begin(), middle, costs_.end());
    limit_ = *middle;
    for (const std::uint32_t v : open_) {
      if (is_closed_[v] == 0 && least_cost_[v] <= limit_) candidates_.push_back(v);
    }
    return true;
  }
  double least_cost(std::uint32_t u) {
    mesh_.ring(u, ring_);
    double least = std::numeric_limits<double>::infinity();
    for (const std::uint32_t c : ring_) {
      least = std::min(least, cost(u, mesh_.vertex(CollapsingMesh::next(c))));
    }
    return least;
  }
  double cost(std::uint32_t u, std::uint32_t v) const {
    return quadrics_[u].at(positions_[v]) + quadrics_[v].at(positions_[v]);
  }

  void try_vertex(std::uint32_t u) {
    if (is_stale_[u] != 0) {
      // Its neighbours have changed in this pass: it may have become too dear.
      least_cost_[u] = least_cost(u);
      is_stale_[u] = 0;
      if (least_cost_[u] > 1.5 * limit_) return;
    }
    mesh_.ring(u, ring_);
    targets_.clear();
    for (const std::uint32_t c : ring_) {
      targets_.push_back({cost(u, mesh_.vertex(CollapsingMesh::next(c))), c});
    }
    std::sort(targets_.begin(), targets_.end());
    int tries = 0;
    for (const Target& target : targets_) {
      const auto at = std::find(ring_.begin(), ring_.end(), target.corner) - ring_.begin();
      CollapsingMesh::turn(ring_, static_cast<std::size_t>(at));
      if (!mesh_.keeps_topology(ring_) || joins_borders() || turns_over()) continue;
      if (try_collapse(u)) return;
      if (++tries == kTries) break;
    }
    is_closed_[u] = 1;
    ++refusals_[u];
  }

  // Whether a new edge would join two vertices of the border. The surface beyond the border may
  // have such an edge too.
  bool joins_borders() const {
    const auto is_inner = [&](std::uint32_t corner) {
      return mesh_.kind(mesh_.vertex(CollapsingMesh::next(corner))) ==
             CollapsingMesh::VertexKind::kInner;
    };
    if (is_inner(ring_[0])) return false;
    for (std::size_t i = 2; i + 1 < ring_.size(); ++i) {
      if (!is_inner(ring_[i])) return true;
    }
    return false;
  }

  bool turns_over() const {
    const std::uint32_t u = mesh_.vertex(ring_[0]);
    const Vec3& to = positions_[mesh_.vertex(CollapsingMesh::next(ring_[0]))];
    for (std::size_t i = 1; i + 1 < ring_.size(); ++i) {
      const Vec3& q = positions_[mesh_.vertex(CollapsingMesh::next(ring_[i]))];
      const Vec3& r = positions_[mesh_.vertex(CollapsingMesh::previous(ring_[i]))];
      const Vec3 before = normal_of(positions_[u], q, r);
      const Vec3 after = normal_of(to, q, r);
      const double along = inner_product(before, after);
      if (!(along > 0) || along * along < 0.04 * squared_length(before) * squared_length(after)) {
        return true;
      }
    }
    return false;
  }

  bool try_collapse(std::uint32_t u) {
    const std::uint32_t v = mesh_.vertex(CollapsingMesh::next(ring_[0]));
    mesh_.collapse(ring_);
    if (!carried_.carry(u, ring_, budget_)) {
      mesh_.take_back(u, ring_);
      return false;
    }
    quadrics_[v].add(quadrics_[u]);
    for (const std::uint32_t c : ring_) {
      const std::uint32_t w = mesh_.vertex(CollapsingMesh::next(c));
      is_stale_[w] = 1;
      if (refusals_[w] < kRefusals) is_closed_[w] = 0;
    }
    is_stale_[v] = 1;
    if (refusals_[v] < kRefusals) is_closed_[v] = 0;
    return true;
  }

  Compacted result() {
    Compacted out{.mesh = {.resolution = input_.resolution, .vertices = {}, .triangles = {}},
                  .bound = carried_.bound()};
    std::vector<std::uint32_t> number(positions_.size(), kNone);
    for (std::uint32_t i = 0; i < mesh_.triangle_count(); ++i) {
      if (mesh_.is_removed(i)) continue;
      TriangleIndices t = mesh_.triangle(i);
      for (std::uint32_t& v : t) {
        if (number[v] == kNone) {
          number[v] = static_cast<std::uint32_t>(out.mesh.vertices.size());
          out.mesh.vertices.push_back(input_.vertices[v]);
        }
        v = number[v];
      }
      out.mesh.triangles.push_back(t);
    }
    return out;
  }

  const LatticeMesh& input_;
  double budget_;
  std::vector<Vec3> positions_;
  CollapsingMesh mesh_;
  std::vector<std::uint8_t> is_anchor_;
  CarriedSurface carried_;
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> open_;      // Vertices that may move some time.
  std::vector<std::uint8_t> is_closed_;  // Refused, and nothing has changed since.
  std::vector<std::uint8_t> refusals_;
  std::vector<std::uint8_t> is_stale_;  // least_cost_ is not known.
  std::vector<double> least_cost_;
  double limit_ = 0;  // Of a pass: the largest cost.
  std::vector<double> costs_;
  std::vector<std::uint32_t> candidates_;
  std::vector<Target> targets_;
  std::vector<std::uint32_t> ring_;
};

}  // namespace

Compacted compacted(const LatticeMesh& mesh, const CompactionOptions& options) {
  if (options.budget == 0 || mesh.triangles.empty()) return {.mesh = mesh, .bound = 0};
  return Compaction(mesh, options).run();
}

}  // namespace multitetra
