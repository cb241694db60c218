#include "server/core/simplification/simplification.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/base/vec3.hpp"
#include "server/core/simplification/detail/collapse_checks.hpp"
#include "server/core/simplification/detail/collapse_fan.hpp"
#include "server/core/simplification/detail/collapsing_mesh.hpp"
#include "server/core/simplification/detail/component_volumes.hpp"
#include "server/core/simplification/detail/first_stage.hpp"
#include "server/core/simplification/detail/quadric.hpp"
#include "server/core/simplification/detail/successive_mapping.hpp"

namespace multitetra {
namespace {

constexpr std::uint32_t kNone = CollapsingMesh::kNone;

std::vector<Vec3> positions_of(const LatticeMesh& mesh, const PieceFrame& frame) {
  std::vector<Vec3> positions;
  positions.reserve(mesh.vertices.size());
  for (const LatticePoint& p : mesh.vertices) positions.push_back(frame.position(p));
  return positions;
}

// Takes the positions, so that their memory is free afterwards.
std::vector<CollapseFan::Point> points_of(std::vector<Vec3> positions,
                                          std::span<const float> errors) {
  std::vector<CollapseFan::Point> points(positions.size());
  for (std::size_t v = 0; v < points.size(); ++v) points[v] = {positions[v], errors[v]};
  return points;
}

}  // namespace

class SimplifiedPiece::Run {
 public:
  // Moves map and quadrics out of the piece, to hold them in memory only once.
  Run(SimplifiedPiece& piece, const PieceLimit& limit, std::vector<CollapseFan::Point> points,
      std::optional<Obstacles> obstacles)
      : limit_(limit),
        points_(std::move(points)),
        mesh_(piece.mesh_.triangles, static_cast<std::uint32_t>(piece.mesh_.vertices.size())),
        quadrics_(piece.take_quadrics()),
        carried_(mesh_, points_, piece.map_, piece.parts_, limit_),
        states_(points_.size()),
        vertices_(piece.mesh_.vertices),
        volumes_(mesh_, vertices_),
        history_(piece.history_ ? &*piece.history_ : nullptr) {
    piece.map_ = {};
    if (obstacles) embedding_.emplace(mesh_, vertices_, *obstacles);
    for (std::uint32_t v = 0; v < points_.size(); ++v) {
      if (mesh_.kind(v) == CollapsingMesh::VertexKind::kInner) open_.push_back(v);
    }
    if (limit.largest() <= piece.smallest_tried_limit_) open_around_seams(piece.parts_);
  }

  // Stores the result in the piece: all of it if it `keeps_state`, otherwise only the mesh.
  void simplify(SimplifiedPiece& piece, const std::function<void()>& checkpoint, bool keeps_state) {
    for (int pass = 0; pass < kPasses && choose_candidates(); ++pass) {
      for (std::size_t i = 0; i < candidates_.size(); ++i) {
        if (i % kBetweenCheckpoints == 0) checkpoint();
        try_vertex(candidates_[i]);
      }
    }
    std::vector<std::uint32_t> numbers(mesh_.triangle_count(), kNone);
    std::vector<TriangleIndices>& triangles = piece.mesh_.triangles;
    triangles.clear();
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
      if (mesh_.is_removed(t)) continue;
      numbers[t] = static_cast<std::uint32_t>(triangles.size());
      triangles.push_back(mesh_.triangle(t));
    }
    triangles.shrink_to_fit();  // Few are left, and the piece may wait for others.
    piece.map_.largest = carried_.largest();
    if (!keeps_state) return;
    piece.map_ = carried_.map(numbers);
    for (std::uint32_t v = 0; v < quadrics_.size(); ++v) {
      if (!carried_.is_carried(v)) piece.quadrics_.push_back(quadrics_[v]);
    }
    piece.quadrics_.shrink_to_fit();
    piece.parts_ = std::vector<std::uint32_t>(triangles.size(), 0);
    piece.smallest_tried_limit_ = limit_.largest();
  }

 private:
  static constexpr int kPasses = 16;
  static constexpr std::size_t kBetweenCheckpoints = 2048;
  static constexpr int kTries = 2;
  static constexpr std::uint8_t kRefusals = 4;
  // Weight of a squared length relative to a squared distance. 0.01 gives up to an eighth fewer
  // thin triangles; 0.03 up to a quarter fewer, but five percent more bytes for flat surfaces.
  static constexpr float kLengthWeight = 0.01F;

  struct State {
    float least_cost = 0;
    std::uint32_t best = kNone;  // The cheapest vertex to collapse onto.
    // The above are outdated.
    bool is_stale = true;
    // Rejected, and its surroundings have not changed since.
    bool is_closed = false;
    std::uint8_t refusals = 0;
  };

  // Away from the seams, the pieces have already tried all collapses, with no smaller limit.
  void open_around_seams(std::span<const std::uint32_t> parts) {
    for (State& state : states_) state.is_closed = true;
    for (std::uint32_t t = 0; t < mesh_.triangle_count(); ++t) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t across = mesh_.opposite(CollapsingMesh::corner_of(t, k));
        if (across == kNone || parts[CollapsingMesh::triangle_of(across)] == parts[t]) continue;
        for (const std::uint32_t v : mesh_.triangle(t)) states_[v].is_closed = false;
      }
    }
  }

  // Chooses the cheaper half of the movable vertices, by number: neighbours are near in memory.
  bool choose_candidates() {
    costs_.clear();
    std::size_t kept = 0;
    for (const std::uint32_t v : open_) {
      if (carried_.is_carried(v)) continue;
      open_[kept++] = v;
      State& state = states_[v];
      if (state.is_closed) continue;
      if (state.is_stale) find_costs(v);
      costs_.push_back(state.least_cost);
    }
    open_.resize(kept);
    candidates_.clear();
    if (costs_.empty()) return false;
    const auto middle = costs_.begin() + static_cast<std::ptrdiff_t>(costs_.size() / 2);
    std::nth_element(costs_.begin(), middle, costs_.end());
    max_cost_ = *middle;
    for (const std::uint32_t v : open_) {
      if (!states_[v].is_closed && states_[v].least_cost <= max_cost_) candidates_.push_back(v);
    }
    return true;
  }
  // Computes the costs of collapses onto the vertices of the ring.
  void find_costs(std::uint32_t u) {
    mesh_.ring(u, ring_);
    ring_costs_.resize(ring_.size());
    ring_positions_.resize(ring_.size());
    State& state = states_[u];
    state.least_cost = std::numeric_limits<float>::infinity();
    state.is_stale = false;
    for (std::size_t i = 0; i < ring_.size(); ++i) {
      const std::uint32_t w = mesh_.vertex(CollapsingMesh::next(ring_[i]));
      ring_positions_[i] = points_[w].at;
      ring_costs_[i] = cost(u, ring_positions_[i]);
      if (ring_costs_[i] < state.least_cost) {
        state.least_cost = ring_costs_[i];
        state.best = w;
      }
    }
  }
  // Where quadrics decide little, as on flat parts, this prefers shorter edges, which leaves fewer
  // long and thin triangles.
  float cost(std::uint32_t u, const Vec3& goal) const {
    const Vec3 along = difference(goal, points_[u].at);
    const Quadric& q = quadrics_[u];
    return q.at(along) + kLengthWeight * q.weight() * static_cast<float>(squared_length(along));
  }

  void try_vertex(std::uint32_t u) {
    State& state = states_[u];
    const bool was_stale = state.is_stale;
    find_costs(u);
    // It may have become too expensive if neighbours have changed in this pass.
    if (was_stale && state.least_cost > 1.5F * max_cost_) return;
    for (int tries = 0; tries < kTries && !ring_costs_.empty();) {
      const auto least = std::min_element(ring_costs_.begin(), ring_costs_.end());
      if (*least == std::numeric_limits<float>::infinity()) break;
      *least = std::numeric_limits<float>::infinity();
      turn_to(static_cast<std::size_t>(least - ring_costs_.begin()));
      if (turns_over(points_[u].at, turned_positions_) || merges_boundaries(mesh_, turned_) ||
          !mesh_.keeps_topology(turned_) || !volumes_.keep_sign(turned_)) {
        continue;
      }
      if (try_collapse(u)) return;
      ++tries;
    }
    state.is_closed = true;
    ++state.refusals;
  }

  // Rotates the ring so that this position is first.
  void turn_to(std::size_t first) {
    turned_.resize(ring_.size());
    turned_positions_.resize(ring_.size());
    for (std::size_t i = 0; i < ring_.size(); ++i) {
      const std::size_t from = first + i < ring_.size() ? first + i : first + i - ring_.size();
      turned_[i] = ring_[from];
      turned_positions_[i] = ring_positions_[from];
    }
  }

  bool try_collapse(std::uint32_t u) {
    if (!carried_.fits(turned_, turned_positions_)) return false;
    if (embedding_ && !embedding_->allows(turned_)) return false;
    carried_.commit(turned_);
    if (embedding_) embedding_->commit(turned_);
    const std::uint32_t v = mesh_.vertex(CollapsingMesh::next(turned_[0]));
    if (history_) history_->add(vertices_[u], vertices_[v], carried_.largest_of_last());
    volumes_.commit(turned_);
    mesh_.collapse(turned_);
    quadrics_[v].add(quadrics_[u].relative_to(difference(points_[v].at, points_[u].at)));
    states_[v].is_stale = true;
    reopen(v);
    for (const std::uint32_t c : turned_) {
      const std::uint32_t w = mesh_.vertex(CollapsingMesh::next(c));
      if (w != v) replace(w, u, v);
    }
    return true;
  }
  // Replaces w's neighbour u by v.
  void replace(std::uint32_t w, std::uint32_t u, std::uint32_t v) {
    State& state = states_[w];
    reopen(w);
    if (state.is_stale) return;
    if (state.best == u) {
      state.is_stale = true;
    } else if (const float to_v = cost(w, points_[v].at); to_v < state.least_cost) {
      state.least_cost = to_v;
      state.best = v;
    }
  }
  void reopen(std::uint32_t vertex) {
    State& state = states_[vertex];
    if (state.refusals < kRefusals) state.is_closed = false;
  }

  const PieceLimit& limit_;
  std::vector<CollapseFan::Point> points_;
  CollapsingMesh mesh_;
  // The quadrics of the vertices, relative to them.
  std::vector<Quadric> quadrics_;
  SuccessiveMapping carried_;
  std::optional<Embedding> embedding_;
  std::vector<State> states_;
  std::vector<std::uint32_t> open_;  // Vertices that may still move.
  std::span<const LatticePoint> vertices_;
  ComponentVolumes volumes_;
  CollapseHistory* history_;  // Null without a history.
  // The maximum cost in a pass.
  float max_cost_ = 0;
  std::vector<float> costs_;
  std::vector<std::uint32_t> candidates_;
  std::vector<std::uint32_t> ring_;
  std::vector<Vec3> ring_positions_;
  std::vector<float> ring_costs_;
  // The ring, starting at the collapse's target.
  std::vector<std::uint32_t> turned_;
  // The positions of the ring's vertices.
  std::vector<Vec3> turned_positions_;
};

SimplifiedPiece::SimplifiedPiece(LatticeMesh mesh, const Vec3& step)
    : mesh_(std::move(mesh)),
      step_(step),
      unit_(*std::min_element(step.begin(), step.end())),
      needs_first_stage_(true) {}

PieceFrame SimplifiedPiece::frame() const {
  return {.unit = unit_,
          .proportions = {step_[0] / unit_, step_[1] / unit_, step_[2] / unit_},
          .origin = mesh_.vertices.front(),
          .lattice_per_voxel = static_cast<double>(1 << mesh_.resolution)};
}

std::vector<Quadric> SimplifiedPiece::take_quadrics() {
  std::vector<Quadric> quadrics = std::exchange(quadrics_, {});
  if (quadrics.empty()) return planes();
  if (quadrics.size() == mesh_.vertices.size()) return quadrics;
  std::vector<Quadric> all(mesh_.vertices.size());
  auto next = quadrics.begin();
  for (std::size_t v = 0; v < all.size(); ++v) {
    if (map_.carriers[v] == kNone) all[v] = *next++;
  }
  return all;
}

std::vector<Quadric> SimplifiedPiece::planes() const {
  const PieceFrame in = frame();
  std::vector<Quadric> quadrics(mesh_.vertices.size());
  for (const auto& [p, q, r] : mesh_.triangles) {
    const Quadric plane =
        Quadric::of_plane(normal_of(in.position(mesh_.vertices[p]), in.position(mesh_.vertices[q]),
                                    in.position(mesh_.vertices[r])));
    quadrics[p].add(plane);
    quadrics[q].add(plane);
    quadrics[r].add(plane);
  }
  return quadrics;
}

void SimplifiedPiece::begin(const AllowedDistance& max_distance, std::optional<Obstacles> obstacles,
                            const std::function<void()>& checkpoint) {
  if (!needs_first_stage_ || max_distance.largest() == 0 || mesh_.triangles.empty()) return;
  SimplifiedPiece taken = std::exchange(*this, {});
  const std::vector<Vec3> positions = positions_of(taken.mesh_, taken.frame());
  const PieceLimit limit(max_distance, taken.frame(), positions);
  FirstStage stage = first_stage(taken.mesh_, positions, limit, obstacles, checkpoint);
  taken.needs_first_stage_ = false;
  taken.mesh_ = std::move(stage.mesh);
  taken.errors_ = std::move(stage.errors);
  for (const float error : taken.errors_) {
    taken.map_.largest = std::max(taken.map_.largest, double{error});
  }
  *this = std::move(taken);
}

void SimplifiedPiece::simplify(const AllowedDistance& max_distance,
                               const std::function<void()>& checkpoint,
                               std::optional<Obstacles> obstacles, int stage, bool is_last) {
  if (max_distance.largest() == 0 || mesh_.triangles.empty()) return;
  begin(max_distance, obstacles, checkpoint);
  SimplifiedPiece taken = std::exchange(*this, {});
  std::vector<Vec3> positions = positions_of(taken.mesh_, taken.frame());
  const PieceLimit limit(max_distance, taken.frame(), positions);
  if (taken.history_) taken.history_->begin(stage);
  Run(taken, limit, points_of(std::move(positions), taken.errors_), obstacles)
      .simplify(taken, checkpoint, !is_last);
  if (is_last) taken.finish();
  if (taken.history_) taken.history_->end();
  *this = std::move(taken);
}

void SimplifiedPiece::finish() {
  mesh_ = result().mesh;
  parts_ = {};
  errors_ = {};
  quadrics_ = {};
  map_ = {.carriers = {}, .edges = {}, .crossings = {}, .largest = map_.largest};
}

void SimplifiedPiece::record_history() {
  std::vector<LatticeTriangle> triangles;
  append_triangles(triangles);
  history_.emplace(std::move(triangles), map_.largest);
}

void SimplifiedPiece::append_triangles(std::vector<LatticeTriangle>& triangles) const {
  for (const auto& [p, q, r] : mesh_.triangles) {
    triangles.push_back({mesh_.vertices[p], mesh_.vertices[q], mesh_.vertices[r]});
  }
}

Simplified SimplifiedPiece::result(double until) const {
  const StoredMapping map{
      .carriers = {}, .edges = {}, .crossings = {}, .largest = history_->bound(until)};
  return {.mesh = history_->mesh(until, mesh_.resolution), .bound = unit_ * map.bound()};
}

Simplified SimplifiedPiece::result() const {
  Simplified out{.mesh = {.resolution = mesh_.resolution, .vertices = {}, .triangles = {}},
                 .bound = unit_ * map_.bound()};
  std::vector<std::uint32_t> number(mesh_.vertices.size(), kNone);
  out.mesh.triangles = mesh_.triangles;
  for (TriangleIndices& t : out.mesh.triangles) {
    for (std::uint32_t& v : t) {
      if (number[v] == kNone) {
        number[v] = static_cast<std::uint32_t>(out.mesh.vertices.size());
        out.mesh.vertices.push_back(mesh_.vertices[v]);
      }
      v = number[v];
    }
  }
  return out;
}

Simplified simplified(const LatticeMesh& mesh, const SimplificationOptions& options,
                      const std::function<void()>& checkpoint) {
  if (options.max_distance.largest() == 0 || mesh.triangles.empty()) {
    return {.mesh = mesh, .bound = 0};
  }
  SimplifiedPiece piece(mesh, options.lattice_step);
  piece.simplify(options.max_distance, checkpoint, options.obstacles(), 0, true);
  return piece.result();
}

}  // namespace multitetra
