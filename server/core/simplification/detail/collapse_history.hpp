// The history of edge collapses, so that the last ones can be undone.
//
// A collapse changes nothing but its fan, so the collapses of pieces that were simplified apart may
// be cut off anywhere, each piece's by itself. `when` orders them all: in a piece, and from what
// was joined to what it became.
#pragma once

#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace multitetra {

// A vertex that moved onto another one. Two triangles vanished.
struct Collapse {
  LatticePoint from, onto;
  double when = 0;
  double distance = 0;  // The largest that was certified for it, in the piece's units.
};

class CollapseHistory {
 public:
  static constexpr double kAll = std::numeric_limits<double>::infinity();

  CollapseHistory() = default;
  // `bound`: of the triangles that are there when it begins.
  CollapseHistory(std::vector<LatticeTriangle> before, double bound)
      : before_(std::move(before)), bound_(bound) {}

  // What is added from now on happens between `stage` and the next whole number. Stages ascend.
  void begin(int stage);
  void add(const LatticePoint& from, const LatticePoint& onto, double distance) {
    collapses_.push_back({.from = from, .onto = onto, .when = stage_, .distance = distance});
  }
  // Ends what begin() began.
  void end();
  // Adds that of another piece of the same surface.
  void append(CollapseHistory other);

  [[nodiscard]] std::span<const Collapse> collapses() const { return collapses_; }
  // The surface after all collapses that happened no later than `until`, with its vertices in the
  // order of their first use; and its bound.
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
