#include "server/core/simplification/detail/first_stage.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "server/core/framework/rounding.hpp"
#include "server/core/simplification/detail/changed_triangles.hpp"
#include "server/core/simplification/detail/collapse_checks.hpp"
#include "server/core/simplification/detail/collapsing_mesh.hpp"
#include "server/core/simplification/detail/component_volumes.hpp"
#include "server/core/simplification/detail/vertex_errors.hpp"

namespace multitetra {
namespace {

constexpr int kPasses = 4;
// A pass that removes a smaller fraction of the vertices is the last.
constexpr double kMinProgress = 0.01;
constexpr std::size_t kBetweenCheckpoints = 8192;
// Without a check per collapse, the few collapses that cause intersections are found afterwards,
// which is faster. Their vertices are then fixed and the stage is repeated; after this many rounds
// all collapses are checked.
constexpr int kUncheckedRounds = 4;
constexpr std::size_t kMaxNeighbours = 32;  // Work grows with their square.
// The weight of a squared length relative to a squared height above the surface. A smaller one
// yields more long and thin triangles in the end.
constexpr double kLengthWeight = 0.5;

// Returns the part of the limit that this stage may use. A larger one leaves less work to the
// second stage but more triangles, especially for small limits.
double first_stage_share(double limit_in_voxels) {
  constexpr double kShareAtOneVoxel = 0.14;
  constexpr double kMaxShare = 0.3;
  return std::min(kShareAtOneVoxel * std::sqrt(limit_in_voxels), kMaxShare);
}

class Sweeps {
 public:
  Sweeps(const LatticeMesh& mesh, std::span<const Vec3> positions, const PieceLimit& limit,
         std::optional<Obstacles> checked_against)
      : vertices_(mesh.vertices),
        positions_(positions),
        limit_(limit),
        largest_(own_limit(limit.largest())),
        mesh_(mesh.triangles, static_cast<std::uint32_t>(positions.size())),
        volumes_(mesh_, vertices_),
        errors_(positions),
        states_(positions.size()),
        goals_(positions.size(), CollapsingMesh::kNone) {
    if (checked_against) embedding_.emplace(mesh_, mesh.vertices, *checked_against);
  }

  // Vertices marked in `stays` do not move.
  void run(std::span<const std::uint8_t> stays, const std::function<void()>& checkpoint) {
    std::vector<std::uint32_t> open;
    for (std::uint32_t v = 0; v < positions_.size(); ++v) {
      if (mesh_.kind(v) == CollapsingMesh::VertexKind::kInner && stays[v] == 0) open.push_back(v);
    }
    for (int pass = 1; pass <= kPasses; ++pass) {
      std::size_t kept = 0;
      std::size_t gone = 0;
      for (std::size_t i = 0; i < open.size(); ++i) {
        if (i % kBetweenCheckpoints == 0) checkpoint();
        const std::uint32_t u = open[i];
        State& state = states_[u];
        if (!state.is_closed && state.pass_as_goal != pass) {
          if (try_vertex(u, pass)) {
            ++gone;
            continue;
          }
          state.is_closed = true;
        }
        open[kept++] = u;
      }
      open.resize(kept);
      if (static_cast<double>(gone) < kMinProgress * static_cast<double>(kept)) break;
    }
  }

  // Adds to `stays` all marked vertices and those that were collapsed onto them.
  void mark_origins(std::span<const std::uint8_t> is_marked,
                    std::vector<std::uint8_t>& stays) const {
    for (std::uint32_t v = 0; v < positions_.size(); ++v) {
      std::uint32_t goal = v;
      while (goals_[goal] != CollapsingMesh::kNone) goal = goals_[goal];
      if (is_marked[goal] != 0) stays[v] = 1;
    }
  }

  [[nodiscard]] const CollapsingMesh& mesh() const { return mesh_; }
  [[nodiscard]] FirstStage result(const LatticeMesh& before) const {
    FirstStage result{.mesh = {.resolution = before.resolution, .vertices = {}, .triangles = {}},
                      .errors = {}};
    const auto left =
        static_cast<std::size_t>(std::count(goals_.begin(), goals_.end(), CollapsingMesh::kNone));
    result.mesh.vertices.reserve(left);
    result.errors.reserve(left);
    // A collapse removes two triangles.
    result.mesh.triangles.reserve(mesh_.triangle_count() - 2 * (goals_.size() - left));
    std::vector<std::uint32_t> number(positions_.size(), CollapsingMesh::kNone);
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
      if (mesh_.is_removed(t)) continue;
      TriangleIndices triangle = mesh_.triangle(t);
      for (std::uint32_t& v : triangle) {
        if (number[v] == CollapsingMesh::kNone) {
          number[v] = static_cast<std::uint32_t>(result.mesh.vertices.size());
          result.mesh.vertices.push_back(before.vertices[v]);
          result.errors.push_back(rounded_up(errors_[v]));
        }
        v = number[v];
      }
      result.mesh.triangles.push_back(triangle);
    }
    return result;
  }

 private:
  struct State {
    std::uint8_t pass_as_goal = 0;  // The last pass in which another vertex was collapsed onto it.
    // Rejected, and its surroundings have not changed since.
    bool is_closed = false;
  };

  [[nodiscard]] double own_limit(double limit) const {
    return first_stage_share(limit_.in_voxels(limit)) * limit;
  }

  // Returns the limit around u's fan. Points that belong to the fan lie within its errors, so
  // within its own limit.
  [[nodiscard]] double limit_around(const Vec3& u) const {
    if (limit_.is_uniform()) return largest_;
    Box box = box_of(places_);
    include(box, u);
    const double there = own_limit(limit_.least_near(box, 0, 0));
    return own_limit(limit_.least_near(box, there, there));
  }

  bool try_vertex(std::uint32_t u, int pass) {
    mesh_.ring(u, ring_);
    if (ring_.size() > kMaxNeighbours) return false;
    turn_to_goal(positions_[u]);
    if (a_triangle_turns_over() || merges_boundaries(mesh_, ring_)) return false;
    const double limit = limit_around(positions_[u]);
    if (!(limit > 0) || !errors_.fits(u, neighbours_, places_, limit)) return false;
    if (!mesh_.keeps_topology(ring_) || !volumes_.keep_sign(ring_)) return false;
    if (embedding_ && !embedding_->allows(ring_)) return false;
    errors_.commit();
    if (embedding_) embedding_->commit(ring_);
    volumes_.commit(ring_);
    mesh_.collapse(ring_);
    goals_[u] = neighbours_.front();
    states_[neighbours_.front()].pass_as_goal = static_cast<std::uint8_t>(pass);
    for (const std::uint32_t w : neighbours_) states_[w].is_closed = false;
    return true;
  }

  // Rotates the ring to begin with the neighbour that u is cheapest to move onto: along the
  // surface, and near.
  void turn_to_goal(const Vec3& u) {
    places_.clear();
    for (const std::uint32_t corner : ring_) {
      places_.push_back(positions_[mesh_.vertex(CollapsingMesh::next(corner))]);
    }
    Vec3 normal = {0, 0, 0};
    normals_.clear();
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const Vec3& next = places_[i + 1 < places_.size() ? i + 1 : 0];
      normal = sum(normal, normals_.emplace_back(normal_of(u, places_[i], next)));
    }
    const double squared_normal = squared_length(normal);
    const double inverse = squared_normal > 0 ? 1 / squared_normal : 0;
    double least = std::numeric_limits<double>::infinity();
    goal_ = 0;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const Vec3 along = difference(u, places_[i]);
      const double height = dot(along, normal);
      const double cost = height * height * inverse + kLengthWeight * squared_length(along);
      if (cost < least) {
        least = cost;
        goal_ = i;
      }
    }
    std::rotate(ring_.begin(), ring_.begin() + static_cast<std::ptrdiff_t>(goal_), ring_.end());
    std::rotate(places_.begin(), places_.begin() + static_cast<std::ptrdiff_t>(goal_),
                places_.end());
    neighbours_.clear();
    for (const std::uint32_t corner : ring_) {
      neighbours_.push_back(mesh_.vertex(CollapsingMesh::next(corner)));
    }
  }

  [[nodiscard]] bool a_triangle_turns_over() const {
    for (std::size_t i = 1; i + 1 < places_.size(); ++i) {
      const std::size_t at = goal_ + i < places_.size() ? goal_ + i : goal_ + i - places_.size();
      if (turns_over(normals_[at], places_, i)) return true;
    }
    return false;
  }

  std::span<const LatticePoint> vertices_;
  std::span<const Vec3> positions_;
  const PieceLimit& limit_;
  double largest_;  // This stage's limit where it is uniform.
  CollapsingMesh mesh_;
  ComponentVolumes volumes_;
  VertexErrors errors_;
  std::optional<Embedding> embedding_;
  std::vector<State> states_;
  std::vector<std::uint32_t> goals_;  // The vertices onto which removed vertices moved.
  std::vector<std::uint32_t> ring_, neighbours_;
  std::vector<Vec3> places_;
  // Normals of the ring's triangles before it was rotated by `goal_` places.
  std::vector<Vec3> normals_;
  std::size_t goal_ = 0;
};

}  // namespace

FirstStage first_stage(const LatticeMesh& mesh, std::span<const Vec3> positions,
                       const PieceLimit& limit, std::optional<Obstacles> obstacles,
                       const std::function<void()>& checkpoint) {
  std::vector<std::uint8_t> stays(positions.size(), 0);
  if (!obstacles) {
    Sweeps sweeps(mesh, positions, limit, std::nullopt);
    sweeps.run(stays, checkpoint);
    return sweeps.result(mesh);
  }
  ChangedTriangles changed(mesh, *obstacles);
  for (int round = 0; round < kUncheckedRounds; ++round) {
    Sweeps sweeps(mesh, positions, limit, std::nullopt);
    sweeps.run(stays, checkpoint);
    const std::vector<std::uint8_t> corners = changed.intersecting_corners(sweeps.mesh());
    if (corners.empty()) return sweeps.result(mesh);
    sweeps.mark_origins(corners, stays);
  }
  std::fill(stays.begin(), stays.end(), std::uint8_t{0});
  Sweeps sweeps(mesh, positions, limit, obstacles);
  sweeps.run(stays, checkpoint);
  return sweeps.result(mesh);
}

}  // namespace multitetra
