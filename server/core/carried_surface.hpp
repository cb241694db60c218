// How far a surface is from the one it was compacted from: a bound in both directions, kept up to
// date from collapse to collapse, that does not add up over them.
//
// The argument. Let M be the original surface and N the compacted one, whose vertices are some of
// M's. A continuous map from M onto N that moves no point farther than e proves that no point of
// either is farther than e from the other. Such a map is kept here:
//
//  * A vertex of M that N still has stays. Any other is *carried* by a triangle of N: its image is
//    the nearest point there.
//  * An edge of M between two vertices crosses the edges of N between their carriers, going around
//    one vertex of N, its *pivot*: points of the edge, in their order, are mapped to near points of
//    the crossed edges.
//  * A triangle of M is cut along chords between its corners and these crossings into smaller ones,
//    so that all corners of each have images in one triangle of N. There the map is linear. A
//    linear map from triangle to triangle moves no point farther than the corner that it moves
//    farthest (a distance is a convex function), so corners and crossings are all that is ever
//    looked at.
//
// The map is continuous, since an edge of M has one path whichever triangle looks at it. It is
// *onto*: let a component of M have a border. The border stays point for point, so the image of the
// component is a chain with the border of N's component, and the only one is all of N's component
// (H2(N, border) -> H1(border) is injective). A component without border has a triangle that stays,
// its *anchor*, which nothing else is mapped into; the image covers it once, so it covers all of
// the component once.
//
// A collapse for which these rules find no map, or one that moves a point too far, is refused. That
// maps between successive surfaces bound the distance, and how their triangles overlay, is the idea
// of J. Cohen, D. Manocha, M. Olano, "Simplifying polygonal models using successive mappings" (IEEE
// Visualization 1997). They compose the maps, so bounds add up; here every map goes back to the
// original, made anew from what carries its vertices.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/affine.hpp"
#include "server/core/collapsing_mesh.hpp"

namespace multitetra {

class CarriedSurface {
 public:
  // `mesh` still has all triangles of the original; all that is referred to must stay valid.
  // `is_anchor` says which triangles nothing may be mapped into.
  CarriedSurface(const CollapsingMesh& mesh, std::span<const TriangleIndices> original,
                 std::span<const Vec3> positions, std::span<const std::uint8_t> is_anchor);

  // Carries everything over a collapse that the mesh has just made: of the vertex u, with `ring` as
  // CollapsingMesh::collapse left it. False when that would move a point farther than `limit`, or
  // is not possible at all; then nothing has changed here.
  [[nodiscard]] bool carry(std::uint32_t u, std::span<const std::uint32_t> ring, double limit);

  [[nodiscard]] bool is_carried(std::uint32_t vertex) const { return carrier_[vertex] != kNone; }
  // No point was moved farther.
  [[nodiscard]] double bound() const;

 private:
  static constexpr std::uint32_t kNone = CollapsingMesh::kNone;
  static constexpr std::int32_t kMaxTurns = 4;
  static constexpr std::size_t kMaxCrossings = kMaxTurns;

  // A triangle around the vertex that a collapse ends on.
  struct NewTriangle {
    std::uint32_t index = 0;
    Vec3 first, second;            // Dual to its edges from v.
    Vec3 normal;                   // Of length 1.
    Vec3 edge_first, edge_second;  // From v.
  };
  struct Ends {
    std::uint32_t low = 0;
    std::uint32_t high = 0;
  };
  // An edge at a vertex of the original.
  struct Spoke {
    std::uint32_t edge = 0;
    std::uint32_t other = 0;  // Its other end.
  };
  // How an original edge goes from one end's carrier to the other end: around the pivot. It starts
  // at the lower end, unless only the higher one is carried.
  struct Route {
    std::uint32_t pivot = kNone;  // None: all is in one triangle, or an edge of N.
    std::int32_t turns = 0;       // Edges of N that are crossed, negative against the ring's order.
  };
  // Those edges, by the corners opposite to them on the side where the route comes from.
  struct Crossings {
    std::array<std::uint32_t, kMaxCrossings> corners{};
    std::size_t count = 0;
  };
  // An original triangle's border as its image goes through the triangles of N.
  class Outline;

  void set_up(std::span<const std::uint32_t> ring);
  [[nodiscard]] bool assign(std::uint32_t vertex);
  [[nodiscard]] bool reroute(std::span<const std::uint32_t> ring);
  [[nodiscard]] bool reroute(std::uint32_t edge, std::uint32_t preferred_pivot);
  [[nodiscard]] Route shortest_route(const Ends& ends, std::uint32_t preferred_pivot) const;
  [[nodiscard]] std::int32_t turns_around(const Ends& ends, std::uint32_t pivot,
                                          std::int32_t most) const;
  void follow(const Ends& ends, const Route& route, Crossings& crossings) const;
  [[nodiscard]] bool is_within_limit(const Ends& ends, const Route& route);
  [[nodiscard]] bool is_cut(std::uint32_t original_triangle) const;
  [[nodiscard]] bool is_cut_around_a_pivot(std::uint32_t original_triangle) const;
  [[nodiscard]] bool holds(std::uint32_t triangle, std::uint32_t vertex) const {
    const TriangleIndices& t = mesh_.triangle(triangle);
    return t[0] == vertex || t[1] == vertex || t[2] == vertex;
  }
  void keep(std::span<const std::uint32_t> ring);
  void pass(std::uint32_t edge, std::uint32_t triangle);
  void undo();

  const CollapsingMesh& mesh_;
  std::span<const TriangleIndices> original_;
  std::span<const Vec3> positions_;
  std::span<const std::uint8_t> is_anchor_;

  // The original's edges. Corner c of it is opposite to edge edge_of_[c].
  std::vector<Ends> ends_;
  std::vector<std::array<std::uint32_t, 2>> sides_;  // The triangles at an edge, or kNone.
  std::vector<std::uint32_t> edge_of_;
  std::vector<std::uint32_t> spokes_begin_;  // The edges at its vertices.
  std::vector<Spoke> spokes_;

  // The map.
  std::vector<std::uint32_t> carrier_;  // Of a vertex: the triangle that carries it, or kNone.
  std::vector<Route> routes_;           // Of an edge.
  double squared_bound_ = 0;

  // What a triangle of N carries, as lists: vertices, and edges that only pass.
  struct Passing {
    std::uint32_t edge = 0;
    std::uint32_t next = kNone;
  };
  std::vector<std::uint32_t> first_carried_;
  std::vector<std::uint32_t> next_carried_;
  std::vector<std::uint32_t> first_passing_;
  std::vector<Passing> passing_;

  // Memory to work in: what a collapse touches.
  double squared_limit_ = 0;
  double largest_ = 0;
  Vec3 apex_ = {0, 0, 0};
  std::vector<NewTriangle> fan_;
  std::vector<std::array<std::uint32_t, 2>> touched_;  // Vertices, and what carried them before.
  struct Rerouted {
    std::uint32_t edge = 0;
    Route before;
  };
  std::vector<Rerouted> rerouted_;
  std::vector<std::uint32_t> cut_;        // Triangles of the original.
  std::vector<std::uint32_t> seen_edge_;  // In which collapse.
  std::vector<std::uint32_t> seen_triangle_;
  std::uint32_t now_ = 0;
};

}  // namespace multitetra
