// Bounds the distance of a surface from the one it was simplified from: in both directions, kept up
// to date from collapse to collapse, that does not add up over them.
//
// The argument. Let M be the original surface and N the simplified one, whose vertices are some of
// M's. The collapses make a continuous map h of M onto N that leaves these vertices where they are,
// and the border too, and that covers every point once, if coverings are counted with their signs.
// Nothing else comes to lie on these vertices: all is drawn inside of fans, which have none there.
// How far h moves points does not matter. All that is kept of it is
//
//  * which triangle of N *carries* a vertex of M: its image lies there;
//  * which edges of N an edge of M *crosses* on its way, as its image does.
//
// When every vertex of M is within e of the triangle that carries it, and every edge of M within e
// of each edge of N that it crosses, then no point of M is farther than e from N, and no point of N
// is farther than e from M. For:
//
//  * Where an edge m of M crosses an edge n of N, let x be a point of m within e of n. What h maps
//    into n is drawn anew: in each triangle of M straight from one such point to the next. That is
//    a *path* with the same ends as n, and within e of it, since a distance from something convex
//    is a convex function.
//  * The paths of the edges of a triangle t of N bound a *region* of M, its parts counted as often
//    as h covers t. The region's corners are vertices that t carries, points x, and points where
//    two of the paths meet: so all of it is within e of t. The regions add up to M, as what h maps
//    into each triangle did. So every point of M is within e of N.
//  * Now move every point of the region to the nearest point of t, and then every point of its
//    paths straight on to the nearest point of n. All this stays in t, and its border goes around t
//    once; so it passes every point of t. What passes it came from a point within e: on the way
//    from the nearest point of t to that of n the distance is at most the one to n, again because
//    it is convex. So every point of N is within e of M.
//
// A collapse changes h only in the fan of triangles that v gets. A fan is a disc with all its
// vertices on its border, so images of vertices may be placed anywhere in it, and an edge between
// two places can be drawn there in only one way, up to deformation: it crosses the *spokes* between
// them.
//
//     w2---------w1
//      | `.   1  /      The fan: triangles 1 .. n - 2, its *sectors*, between v, w_k and w_(k+1).
//      |   `.   /       Spokes go from v to w_k; those between two sectors, k = 2 .. n - 2, can be
//      |  2  `./        crossed.
//     w3-------v
//
// Maps of pieces that were simplified apart leave the borders of the pieces where they are. So
// together they are such a map of the surface that the pieces make up.
//
// That maps from one surface to the other bound their distance is the idea of J. Cohen, D. Manocha,
// M. Olano, "Simplifying polygonal models using successive mappings" (IEEE Visualization 1997).
// Their maps go from each surface to the next one, so that bounds add up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/base/affine.hpp"
#include "server/core/simplification/detail/allowed_distance.hpp"
#include "server/core/simplification/detail/collapse_fan.hpp"
#include "server/core/simplification/detail/collapsing_mesh.hpp"

namespace multitetra {

// What is kept of a map from M onto N between one simplification and the next: in numbers of M's
// vertices, and of N's triangles and corners as in collapsing_mesh.hpp. Pieces are joined by
// putting their maps together.
struct StoredMapping {
  static constexpr std::uint32_t kNone = CollapsingMesh::kNone;
  // Relative, and more than what rounding takes from a distance, to the thinnest triangles too.
  static constexpr double kRounding = 1e-6;

  // An edge of M, between two of its triangles. low < high.
  struct Edge {
    std::uint32_t low = 0;
    std::uint32_t high = 0;
    // The end of its crossings; they begin where those of the edge before end.
    std::uint32_t end = 0;
  };
  // For every vertex of M; kNone: it is a vertex of N.
  std::vector<std::uint32_t> carriers;
  std::vector<Edge> edges;
  // For every crossing, from the low end on: a corner opposite to the edge of N.
  std::vector<std::uint32_t> crossings;
  double largest = 0;  // No distance of a pair is larger, but for rounding.

  // No distance is larger.
  [[nodiscard]] double bound() const;
  // Adds that of another piece of surface. Its vertices have the numbers `vertices` here; its
  // triangles come from `first_triangle` on. New vertices are those beyond the ones known so far.
  void append(const StoredMapping& other, std::span<const std::uint32_t> vertices,
              std::uint32_t first_triangle);
};

class SuccessiveMapping {
 public:
  // N is what `mesh` is now. Edges of N between triangles with different `parts` are edges of M
  // that the map has not; without parts each triangle is one, and N is M. `points` are M's vertices
  // with their errors. What is referred to must stay valid.
  SuccessiveMapping(const CollapsingMesh& mesh, std::span<const CollapseFan::Point> points,
                    const StoredMapping& map, std::span<const std::uint32_t> parts,
                    const PieceLimit& limit);

  // Whether u can collapse onto w_0 of its ring without any distance becoming larger than the
  // limit. `ring` are u's corners, `places` where w_0, w_1, ... are, and nothing is moved yet.
  [[nodiscard]] bool fits(std::span<const std::uint32_t> ring, std::span<const Vec3> places);
  // Makes all as it is after that collapse, which was the last that was found to fit.
  void keep(std::span<const std::uint32_t> ring);

  // The largest distance that was certified for it.
  [[nodiscard]] double largest_of_last() const { return fan_.largest(); }
  // No distance of a pair is larger, but for rounding.
  [[nodiscard]] double largest() const { return largest_; }

  [[nodiscard]] bool is_carried(std::uint32_t vertex) const { return is_carried_[vertex] != 0; }
  // The map as it is; `numbers` are those of N's triangles there. Every edge of N has become one
  // that the map has.
  [[nodiscard]] StoredMapping map(std::span<const std::uint32_t> numbers) const;

 private:
  static constexpr std::uint32_t kNone = CollapsingMesh::kNone;
  static constexpr std::uint32_t kFanEdge = kNone;
  static constexpr double kLargestLimit = 1e150;  // Its square is finite.
  // In `seen`, of a vertex that is no carried one. No surface has so many vertices to collapse.
  static constexpr std::uint32_t kStays = std::uint32_t{1} << 31;
  // The fan's triangles from one to another.
  struct Sectors {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
  };
  struct Vertex {
    std::uint32_t next_carried = kNone;  // By the same triangle.
    std::uint32_t seen = 0;              // In which collapse it was in the fan,
    Sectors sectors;                     // and where.
  };
  // An edge of the original, as it is seen from one of its ends. Its number as an edge is that of
  // the half at its low end.
  struct Half {
    std::uint32_t other = 0;      // The other end,
    std::uint32_t twin = 0;       // and the half there.
    std::uint32_t first = kNone;  // The crossing that comes first from here.
  };
  // An edge of the simplified surface.
  struct Edge {
    std::uint32_t crossed = kNone;  // A list of the crossings on it.
    std::uint32_t seen = 0;         // In which collapse; then
    std::uint32_t place = 0;        // kFanEdge, or i when it goes from w_i to w_(i+1).
  };
  struct Crossing {
    std::uint32_t half = kNone;  // The low one; kNone when the crossing is no more.
    std::uint32_t on = kNone;    // The edge that is crossed.
    std::uint32_t previous = kNone, next = kNone;  // Along the original edge.
    std::uint32_t next_on = kNone;                 // In the list of `on`.
    std::uint32_t seen = 0;
  };
  // A piece of an original edge inside of the ring, from the low end on.
  struct OverlaySegment {
    std::uint32_t half = 0;
    std::uint32_t before = kNone, after = kNone;  // Crossings of the ring, or none at an end.
    std::uint32_t from = 0, to = 0;               // Sectors.
  };

  void number_edges();
  void add_edges(const StoredMapping& map, std::span<const std::uint32_t> parts);
  void add_crossings(const StoredMapping& map);
  [[nodiscard]] bool measure(std::span<const std::uint32_t> ring, std::span<const Vec3> places,
                             double limit);
  [[nodiscard]] bool measure_locally(std::span<const std::uint32_t> ring,
                                     std::span<const Vec3> places);
  [[nodiscard]] bool measure_rim(std::span<const std::uint32_t> ring, std::span<const Vec3> places);
  void include(std::uint32_t vertex);
  // The ends of the edge with this low half.
  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> ends(std::uint32_t half) const {
    return {halves_[halves_[half].twin].other, halves_[half].other};
  }
  [[nodiscard]] bool place(std::uint32_t vertex);
  void mark(std::span<const std::uint32_t> ring);
  [[nodiscard]] bool find_strands_of_vertices();
  [[nodiscard]] bool find_passing_segments(std::span<const std::uint32_t> ring);
  // The edge with this low half, from `low` to `high`.
  [[nodiscard]] bool add_strand(std::uint32_t half, std::uint32_t low, std::uint32_t high,
                                std::uint32_t before, std::uint32_t after, bool had_crossings);
  [[nodiscard]] Sectors sectors_at(std::uint32_t crossing, std::uint32_t vertex) const;
  void keep_strand(const OverlaySegment& strand, std::span<const std::uint32_t> ring);
  [[nodiscard]] bool is_fan_edge(std::uint32_t edge) const {
    return edges_[edge].seen == now_ && edges_[edge].place == kFanEdge;
  }

  const CollapsingMesh& mesh_;
  std::span<const CollapseFan::Point> points_;
  const PieceLimit& limit_;
  std::vector<Edge> edges_;
  std::vector<std::uint32_t> edge_of_;       // Opposite to a corner.
  std::vector<std::uint32_t> halves_begin_;  // At a vertex.
  std::vector<Half> halves_;
  std::vector<Vertex> vertices_;
  std::vector<std::uint8_t> is_carried_;
  // The first vertex that each triangle carries.
  std::vector<std::uint32_t> first_carried_;
  std::vector<Crossing> crossings_;
  std::uint32_t free_ = kNone;
  double largest_ = 0;

  // The state of one collapse.
  std::uint32_t now_ = 0;
  CollapseFan fan_;
  std::vector<std::uint32_t> placed_;
  std::vector<OverlaySegment> strands_;
  // Where limits differ: a box around all that lies in the fan, and the largest error in it.
  Box region_ = {};
  double largest_error_ = 0;
};

}  // namespace multitetra
