// The same surface with fewer triangles.
//
//   const Simplified tile =
//       simplified(mesh, {.lattice_step = {delta, delta, delta}, .max_distance = 0.25});
//
// Edges collapse onto one of their ends, so that every vertex that is left is one of the vertices
// before. What is guaranteed:
//
//  * no point of either surface is farther from the other than `bound`, which is at most the
//    largest `max_distance` (see successive_mapping.hpp and vertex_errors.hpp for the proof);
//  * where the `max_distance` differs from place to place, no point of either surface is farther
//    from the other than is allowed where it lies, and where the points are that it was compared
//    with;
//  * the border, and every vertex without a closed ring of triangles around it, is as before:
//    meshes that fit together still do;
//  * the topology is the same: what was a manifold is one, with the same components and Euler
//    characteristic; a component without border keeps four triangles at least;
//  * no triangle turns by as much as a right angle in a collapse, and none is degenerate;
//  * with `embedded`, a surface without self-intersections stays so (see embedding.hpp);
//  * the result is a function of the arguments alone, to the bit.
//
// Where the `max_distance` is 0 nothing changes.
//
// A large surface is simplified in pieces, which are joined and simplified on: then what was border
// between them goes as well. The bound stays one to the surface before anything was simplified.
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
  Vec3 lattice_step = {1, 1, 1};     // Length of a lattice step along each axis.
  AllowedDistance max_distance = 0;  // In the unit of `lattice_step`.
  // Whether a surface that does not cut itself stays so. It takes two to three times as long, and
  // leaves a few percent more triangles.
  bool is_embedded = false;
  // Whether tiles may be simplified on later, or back to what they were after the first stage: they
  // keep what that needs.
  bool is_resumable = false;

  [[nodiscard]] std::optional<Obstacles> embedded() const {
    return is_embedded ? std::optional(Obstacles()) : std::nullopt;
  }
};

struct Simplified {
  // Vertices in the order in which its triangles first use them, and no normals; with a
  // `max_distance` of 0 what it was.
  LatticeMesh mesh;
  double bound = 0;
};

// Requires triangles of three different vertices each. `checkpoint` is called now and then: what it
// throws ends the work.
[[nodiscard]] Simplified simplified(
    const LatticeMesh& mesh, const SimplificationOptions& options,
    const std::function<void()>& checkpoint = [] {});

class SimplifiedPiece {
 public:
  SimplifiedPiece() = default;
  // Requires triangles of three different vertices each; `step` as the lattice_step of
  // SimplificationOptions.
  SimplifiedPiece(LatticeMesh mesh, const Vec3& step);
  // Requires pieces of one surface, with the same steps, that have nothing in common but borders.
  // Each is let go as soon as it is part of the whole.
  [[nodiscard]] static SimplifiedPiece joined(std::vector<SimplifiedPiece> pieces);

  // `max_distance` as in SimplificationOptions. Pieces that were simplified with another one keep
  // the bound that they have, where it is the larger. When `checkpoint` throws, which is called now
  // and then, nothing is left of the piece. With `embedded` it stays a surface that does not cut
  // itself, nor those obstacles. `stage` is that of the history, if one is kept. With `is_last` it
  // is finished afterwards, which saves what simplifying on would need.
  void simplify(
      const AllowedDistance& max_distance, const std::function<void()>& checkpoint = [] {},
      std::optional<Obstacles> embedded = std::nullopt, int stage = 0, bool is_last = false);
  // The first stage alone, which is quick. For a piece that is to be joined with others.
  void begin(const AllowedDistance& max_distance, std::optional<Obstacles> embedded,
             const std::function<void()>& checkpoint);

  // Lets go of what simplifying on, or joining, would need.
  void finish();
  // From now on collapses can be left out again, but for those of the first stage. Of pieces that
  // are joined either all have a history, or none.
  void keep_history();
  [[nodiscard]] std::span<const Collapse> history() const {
    return history_ ? history_->collapses() : std::span<const Collapse>();
  }

  // Neither simplified nor joined: the first stage comes first.
  [[nodiscard]] bool is_new() const { return is_new_; }
  [[nodiscard]] int resolution() const { return mesh_.resolution; }
  [[nodiscard]] std::size_t triangles() const { return mesh_.triangles.size(); }
  // At the beginning, or after the first stage.
  [[nodiscard]] std::size_t vertices_before() const { return mesh_.vertices.size(); }
  [[nodiscard]] Simplified result() const;
  // After those collapses of its history that happened no later than `until`.
  [[nodiscard]] Simplified result(double until) const;
  // What is left.
  void append_triangles(std::vector<LatticeTriangle>& triangles) const;

 private:
  class Run;

  void reserve(std::span<const SimplifiedPiece> pieces);
  void append(SimplifiedPiece piece, VertexNumbers& shared);
  // Makes the quadrics those of its triangles.
  void add_planes();
  // In units, so that it does not matter in which unit datasets are measured. Requires a vertex.
  [[nodiscard]] PieceFrame frame() const;

  // All vertices that were there after the first stage; the triangles that are left.
  LatticeMesh mesh_;
  Vec3 step_ = {1, 1, 1};
  double unit_ = 1;  // The shortest of them.
  // For every triangle, as SuccessiveMapping takes them: in which of the pieces that were joined it
  // is.
  std::vector<std::uint32_t> parts_;
  bool is_new_ = false;
  // The errors of the vertices after the first stage, in units; none before it.
  std::vector<float> errors_;
  // The quadrics of the vertices, relative to them, in units; none before the first stage.
  std::vector<Quadric> quadrics_;
  StoredMapping map_;  // In units.
  std::optional<CollapseHistory> history_;
  // Limit, in units: no collapse within it is left inside of the parts.
  double least_tried_ = 0;
};

}  // namespace multitetra
