// Reduces the triangles of a surface within a certified distance.
//
//   const Simplified tile =
//       simplified(mesh, {.lattice_step = {delta, delta, delta}, .max_distance = 0.25});
//
// Edges collapse onto one of their ends, so the remaining vertices are original ones. Guarantees:
//
//  * no point of either surface is farther from the other than `bound`, which is at most the
//    largest `max_distance` (see successive_mapping.hpp and vertex_errors.hpp for the proof);
//  * if `max_distance` varies, no point of either surface is farther from the other than is allowed
//    both at the point and at the points it is compared with;
//  * the border, and every vertex without a closed ring of triangles around it, is unchanged:
//    adjacent meshes still fit together;
//  * the topology is preserved: manifolds stay manifolds, with the same components and Euler
//    characteristic; a component without border keeps at least four triangles, and does not turn
//    inside out (for pieces of a surface see component_volumes.hpp);
//  * no triangle turns by as much as a right angle in a collapse, and none is degenerate;
//  * with `is_intersection_free`, a surface without self-intersections gets none (embedding.hpp);
//  * the result depends only on the arguments, to the bit.
//
// Where `max_distance` is 0, nothing changes.
//
// A large surface is simplified in pieces, which are then joined and simplified further, including
// the borders between them. The bound remains one to the original surface.
//
//   SimplifiedPiece left(mesh, step), right(other_mesh, step);
//   left.simplify(0.25);
//   right.simplify(0.25);
//   SimplifiedPiece whole = SimplifiedPiece::joined({left, right});
//   whole.simplify(0.25);
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "common/base/affine.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/vertex_numbers.hpp"
#include "server/core/simplification/detail/allowed_distance.hpp"
#include "server/core/simplification/detail/collapse_history.hpp"
#include "server/core/simplification/detail/embedding.hpp"
#include "server/core/simplification/detail/first_stage.hpp"
#include "server/core/simplification/detail/quadric.hpp"
#include "server/core/simplification/detail/successive_mapping.hpp"

namespace multitetra {

struct SimplificationOptions {
  // Length of a lattice step along each axis.
  Vec3 lattice_step = {1, 1, 1};
  // In the unit of `lattice_step`.
  AllowedDistance max_distance = 0;
  // Adds no intersections to surfaces without any: takes 2 to 3 times as long, leaves a few percent
  // more triangles.
  bool is_intersection_free = false;
  // Keeps the data to simplify tiles further or to restore their state after the first stage.
  bool is_resumable = false;

  // Returns no obstacles other than the surface itself, or nullopt if it may intersect itself.
  [[nodiscard]] std::optional<Obstacles> obstacles() const {
    return is_intersection_free ? std::optional(Obstacles()) : std::nullopt;
  }
};

struct Simplified {
  // Vertices are in the order in which triangles first use them, without normals; for a
  // `max_distance` of 0 the mesh is unchanged.
  LatticeMesh mesh;
  double bound = 0;
};

// Requires triangles with three different vertices each. Calls `checkpoint` repeatedly; an
// exception from it aborts the work.
[[nodiscard]] Simplified simplified(
    const LatticeMesh& mesh, const SimplificationOptions& options,
    const std::function<void()>& checkpoint = [] {});

class SimplifiedPiece {
 public:
  SimplifiedPiece() = default;
  // Requires triangles with three different vertices each; `step` is the lattice_step of
  // SimplificationOptions.
  SimplifiedPiece(LatticeMesh mesh, const Vec3& step);
  // Joins pieces of one surface. They must have the same step and share only borders. Releases each
  // piece once it is part of the whole.
  [[nodiscard]] static SimplifiedPiece joined(std::vector<SimplifiedPiece> pieces);

  // Simplifies the piece; `max_distance` as in SimplificationOptions. The bound of an earlier
  // simplification remains if it is larger. Calls `checkpoint` repeatedly; if it throws, the piece
  // is left empty. With `obstacles`, a surface that intersects neither itself nor the obstacles
  // stays intersection-free. `stage` is recorded in the history, if one is kept. With `is_last` the
  // piece is finished afterwards, which saves the work for further simplification.
  void simplify(
      const AllowedDistance& max_distance, const std::function<void()>& checkpoint = [] {},
      std::optional<Obstacles> obstacles = std::nullopt, int stage = 0, bool is_last = false);
  // Runs only the fast first stage, unless it has run.
  void begin(const AllowedDistance& max_distance, std::optional<Obstacles> obstacles,
             const std::function<void()>& checkpoint);

  // Frees the data for further simplification or joining.
  void finish();
  // Starts recording collapses so that they can be undone; those of the first stage cannot. Either
  // all pieces that are joined have a history, or none.
  void record_history();
  [[nodiscard]] std::span<const Collapse> history() const {
    return history_ ? history_->collapses() : std::span<const Collapse>();
  }

  // Returns whether the piece has been neither simplified, except by its first stage, nor joined.
  [[nodiscard]] bool is_new() const { return parts_.empty(); }
  [[nodiscard]] int resolution() const { return mesh_.resolution; }
  [[nodiscard]] std::size_t triangles() const { return mesh_.triangles.size(); }
  // Returns the number of vertices at the beginning or, if later, after the first stage.
  [[nodiscard]] std::size_t vertices_before() const { return mesh_.vertices.size(); }
  [[nodiscard]] Simplified result() const;
  // Returns the result of those collapses of its history with `when` <= `until`.
  [[nodiscard]] Simplified result(double until) const;
  // Appends the remaining triangles.
  void append_triangles(std::vector<LatticeTriangle>& triangles) const;

 private:
  class Run;

  void reserve(std::span<const SimplifiedPiece> pieces);
  void append(SimplifiedPiece piece, VertexNumbers& shared);
  // Takes the quadrics of all vertices out of the piece; those of carried ones are unused.
  [[nodiscard]] std::vector<Quadric> take_quadrics();
  // Returns the quadrics of its triangles' planes.
  [[nodiscard]] std::vector<Quadric> planes() const;
  // Returns a frame in units, so that results do not depend on the dataset's unit of length.
  // Requires a vertex.
  [[nodiscard]] PieceFrame frame() const;

  // All vertices after the first stage; the remaining triangles.
  LatticeMesh mesh_;
  Vec3 step_ = {1, 1, 1};
  double unit_ = 1;  // The shortest of these steps.
  // By triangle, for SuccessiveMapping: the joined piece that contains it.
  std::vector<std::uint32_t> parts_;
  bool needs_first_stage_ = false;
  // The errors of the vertices after the first stage, in units; empty before it.
  std::vector<float> errors_;
  // The quadrics of the vertices, relative to them, in units. Empty before the second stage;
  // afterwards, unless the piece was joined, only those of vertices that are not carried.
  std::vector<Quadric> quadrics_;
  StoredMapping map_;  // In units.
  std::optional<CollapseHistory> history_;
  // In units: no collapse within this limit is left inside of the parts.
  double smallest_tried_limit_ = 0;
};

}  // namespace multitetra
