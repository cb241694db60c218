#include "server/core/simplification/detail/collapse_history.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "common/mesh/vertex_numbers.hpp"

namespace multitetra {

void CollapseHistory::begin(int stage) {
  stage_ = stage;
  first_of_stage_ = collapses_.size();
}

void CollapseHistory::end() {
  const auto count = static_cast<double>(collapses_.size() - first_of_stage_);
  for (std::size_t i = first_of_stage_; i < collapses_.size(); ++i) {
    collapses_[i].when = stage_ + static_cast<double>(i - first_of_stage_) / count;
  }
}

void CollapseHistory::append(CollapseHistory other) {
  before_.insert(before_.end(), other.before_.begin(), other.before_.end());
  collapses_.insert(collapses_.end(), other.collapses_.begin(), other.collapses_.end());
  bound_ = std::max(bound_, other.bound_);
}

LatticeMesh CollapseHistory::mesh(double until, int resolution) const {
  VertexNumbers numbers;
  std::vector<LatticePoint> vertices;
  std::vector<TriangleIndices> before;
  before.reserve(before_.size());
  for (const LatticeTriangle& t : before_) {
    before.push_back({numbers.number(t[0], vertices), numbers.number(t[1], vertices),
                      numbers.number(t[2], vertices)});
  }
  std::vector<std::uint32_t> goals(vertices.size());
  for (std::uint32_t v = 0; v < goals.size(); ++v) goals[v] = v;
  for (const Collapse& collapse : collapses_) {
    if (collapse.when > until) continue;
    const std::uint32_t from = numbers.number(collapse.from, vertices);
    goals[from] = numbers.number(collapse.onto, vertices);
  }
  const auto goal = [&goals](std::uint32_t v) {
    while (goals[v] != v) v = goals[v] = goals[goals[v]];
    return v;
  };
  std::vector<LatticeTriangle> left;
  for (const auto& [p, q, r] : before) {
    const std::uint32_t a = goal(p), b = goal(q), c = goal(r);
    if (a != b && b != c && c != a) left.push_back({vertices[a], vertices[b], vertices[c]});
  }
  return index_triangles(left, resolution);
}

double CollapseHistory::bound(double until) const {
  double bound = bound_;
  for (const Collapse& collapse : collapses_) {
    if (collapse.when <= until) bound = std::max(bound, collapse.distance);
  }
  return bound;
}

}  // namespace multitetra
