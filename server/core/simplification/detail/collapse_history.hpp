// The history of edge collapses, for undoing the last ones.
//
// A collapse changes only its fan, so the histories of pieces simplified separately can each be cut
// off anywhere. `when` orders all collapses: within a piece, and those before pieces were joined
// before those after.
#pragma once

#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace multitetra {

// A vertex moved onto another one, which removes two triangles.
struct Collapse {
  LatticePoint from, onto;
  double when = 0;
  double distance = 0;  // The largest distance certified for it, in the piece's units.
};

class CollapseHistory {
 public:
  static constexpr double kAll = std::numeric_limits<double>::infinity();

  CollapseHistory() = default;
  // `bound` is that of the initial triangles.
  CollapseHistory(std::vector<LatticeTriangle> before, double bound)
      : before_(std::move(before)), bound_(bound) {}

  // Starts a stage: collapses until end() get times in [stage, stage + 1). Stages must ascend.
  void begin(int stage);
  void add(const LatticePoint& from, const LatticePoint& onto, double distance) {
    collapses_.push_back({.from = from, .onto = onto, .when = stage_, .distance = distance});
  }
  // Ends the current stage.
  void end();
  // Appends the history of another piece of the same surface.
  void append(CollapseHistory other);

  [[nodiscard]] std::span<const Collapse> collapses() const { return collapses_; }
  // Return the surface after all collapses with `when` <= `until`, with its vertices in the order
  // of first use, and its bound.
  [[nodiscard]] LatticeMesh mesh(double until, int resolution) const;
  [[nodiscard]] double bound(double until) const;

 private:
  std::vector<LatticeTriangle> before_;
  double bound_ = 0;
  std::vector<Collapse> collapses_;
  double stage_ = 0;
  std::size_t first_of_stage_ = 0;
};

}  // namespace multitetra
