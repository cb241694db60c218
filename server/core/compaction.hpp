// The same surface with fewer triangles.
//
//   const Compacted tile = compacted(mesh, {.step = {delta, delta, delta}, .budget = 0.25});
//
// Edges collapse onto one of their ends, so that every vertex that is left is one of the vertices
// before. What is guaranteed:
//
//  * no point of either surface is farther from the other than `bound`, which is at most the budget
//    (see carried_surface.hpp for the proof);
//  * the border, and every vertex without a closed ring of triangles around it, is as before:
//    meshes that fit together still do;
//  * the topology is the same: what was a manifold is one, with the same components and Euler
//    characteristic; a component without border keeps four triangles at least;
//  * no triangle turns by as much as a right angle in a collapse, and none is degenerate;
//  * the result is a function of the arguments alone, to the bit.
//
// With a budget of 0 nothing changes.
//
// A large surface is compacted in pieces, which are joined and compacted on: then what was border
// between them goes as well. The bound stays one to the surface before anything was compacted.
//
//   CompactedPiece left(mesh, step), right(other_mesh, step);
//   left.compact(0.25);
//   right.compact(0.25);
//   CompactedPiece whole = CompactedPiece::joined(std::array{left, right});
//   whole.compact(0.25);
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/affine.hpp"
#include "common/mesh.hpp"
#include "common/vertex_numbers.hpp"
#include "server/core/carried_surface.hpp"
#include "server/core/quadric.hpp"

namespace multitetra {

struct CompactionOptions {
  Vec3 step = {1, 1, 1};  // Length of a lattice step along each axis.
  double budget = 0;      // Finite and >= 0, in the unit of `step`.
};

struct Compacted {
  // Vertices in the order in which its triangles first use them, and no normals; with a budget of 0
  // what it was.
  LatticeMesh mesh;
  double bound = 0;
};

// Requires triangles of three different vertices each. `checkpoint` is called now and then: what it
// throws ends the work.
[[nodiscard]] Compacted compacted(
    const LatticeMesh& mesh, const CompactionOptions& options,
    const std::function<void()>& checkpoint = [] {});

class CompactedPiece {
 public:
  CompactedPiece() = default;
  // Requires triangles of three different vertices each; `step` as in CompactionOptions.
  CompactedPiece(LatticeMesh mesh, const Vec3& step);
  // Requires pieces of one surface, with the same steps, that have nothing in common but borders.
  [[nodiscard]] static CompactedPiece joined(std::span<const CompactedPiece> pieces);

  // `budget` as in CompactionOptions. Pieces that were compacted with another one keep the bound
  // that they have, where it is the larger. When `checkpoint` throws, which is called now and then,
  // the piece is as before.
  void compact(
      double budget, const std::function<void()>& checkpoint = [] {});

  [[nodiscard]] std::size_t triangles() const { return mesh_.triangles.size(); }
  // Before anything was compacted.
  [[nodiscard]] std::size_t vertices_before() const { return mesh_.vertices.size(); }
  [[nodiscard]] Compacted result() const;

 private:
  class Run;

  void append(const CompactedPiece& piece, VertexNumbers& shared);
  // Of a lattice step, where the shortest is 1: in which unit datasets are measured does not
  // matter.
  [[nodiscard]] Vec3 proportions() const;

  LatticeMesh mesh_;  // All vertices that ever were; the triangles that are left.
  Vec3 step_ = {1, 1, 1};
  double unit_ = 1;  // The shortest of them.
  // Of every triangle, as CarriedSurface takes them: in which of the pieces that were joined it is.
  std::vector<std::uint32_t> parts_;
  std::vector<Quadric> quadrics_;  // Of the vertices, seen from there; in units.
  CarriedMap map_;                 // In units.
  double least_tried_ = 0;  // Budget, in units: no collapse within it is left inside of the parts.
};

}  // namespace multitetra
