// Bounds the two-sided Hausdorff distance of a surface from the one it was simplified from. The
// bound is updated with every collapse and does not accumulate over them.
//
// The argument. Let M be the original surface and N the simplified one, whose vertices are a subset
// of M's. The collapses define a continuous map h of M onto N that fixes these vertices and the
// border, and that covers every point once, counting coverings with their signs. No other point is
// mapped to these vertices, as all changes happen inside of fans, which have no vertices there. The
// distance by which h moves points is irrelevant. Of h we only store
//
//  * which triangle of N *carries* a vertex of M, that is, contains its image;
//  * which edges of N the image of an edge of M *crosses*.
//
// Suppose that every vertex of M is within e of the triangle that carries it, and every edge of M
// within e of each edge of N that it crosses. Then no point of M is farther than e from N, and no
// point of N is farther than e from M:
//
//  * Where an edge m of M crosses an edge n of N, let x be a point of m within e of n. Redraw the
//    preimage of n: in each triangle of M, straight from one such point to the next. This is a
//    *path* with the same ends as n, and within e of it, since the distance from a convex set is a
//    convex function.
//  * The paths of the edges of a triangle t of N bound a *region* of M, its parts counted as often
//    as h covers t. The region's corners are vertices that t carries, points x, and points where
//    two of the paths meet: so all of it is within e of t. Like the preimages of triangles, the
//    regions add up to M. So every point of M is within e of N.
//  * Now move every point of the region to the nearest point of t, and then every point of its
//    paths straight on to the nearest point of n. All this stays in t, and the region's border ends
//    up going around t once; so the motion covers every point of t. Each of these is within e of
//    the point that moved over it: between the nearest points of t and n its distance is at most
//    the one to n, again by convexity. So every point of N is within e of M.
//
// A collapse changes h only in the fan of triangles that v gets. A fan is a disc with all its
// vertices on its border, so images of vertices may be placed anywhere in it, and an edge between
// two places is unique up to deformation: it crosses the *spokes* between them.
//
//     w2---------w1
//      | `.   1  /      The fan: triangles 1 .. n - 2, its *sectors*, between v, w_k and w_(k+1).
//      |   `.   /       Spokes lead from v to w_k; those between two sectors, k = 2 .. n - 2, can
//      |  2  `./        be crossed.
//     w3-------v
//
// Maps of pieces that were simplified separately fix the borders of the pieces, so together they
// are such a map of the joined surface.
//
// That maps between two surfaces bound their distance is the idea of J. Cohen, D. Manocha, M.
// Olano, "Simplifying polygonal models using successive mappings" (IEEE Visualization 1997). Their
// maps lead from each surface to the next, so their bounds add up.
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

// The stored part of a map from M onto N between two simplifications: in numbers of M's vertices,
// N's triangles and corners (collapsing_mesh.hpp). Maps of joined pieces are concatenated.
struct StoredMapping {
  static constexpr std::uint32_t kNone = CollapsingMesh::kNone;
  // Relative; more than rounding subtracts from a distance, even for the thinnest triangles.
  static constexpr double kRounding = 1e-6;

  // An edge of M between two of its triangles. low < high.
  struct Edge {
    std::uint32_t low = 0;
    std::uint32_t high = 0;
    // End of its crossings, which begin at the end of the previous edge's.
    std::uint32_t end = 0;
  };
  // The carrier of every vertex of M; kNone for vertices of N.
  std::vector<std::uint32_t> carriers;
  std::vector<Edge> edges;
  // For every crossing, in order from the low end: a corner opposite to the edge of N.
  std::vector<std::uint32_t> crossings;
  double largest = 0;  // An upper bound of all distances, except for rounding.

  // Returns an upper bound of all distances, rounding included.
  [[nodiscard]] double bound() const;
  // Appends the map of another piece, whose vertices get the numbers `vertices`, its triangles
  // those from `first_triangle` on. Numbers beyond the existing vertices add new ones.
  void append(const StoredMapping& other, std::span<const std::uint32_t> vertices,
              std::uint32_t first_triangle);
};

class SuccessiveMapping {
 public:
  // N is the current state of `mesh`. Edges of N between triangles of different `parts` are edges
  // of M that are not in the map; without parts, each triangle is a part and N is M. `points` are
  // M's vertices with their errors. All references must remain valid.
  SuccessiveMapping(const CollapsingMesh& mesh, std::span<const CollapseFan::Point> points,
                    const StoredMapping& map, std::span<const std::uint32_t> parts,
                    const PieceLimit& limit);

  // Returns whether u can collapse onto w_0 of its ring without a distance above the limit. `ring`
  // are u's corners before the collapse, `ring_positions` the positions of w_0, w_1, ...
  [[nodiscard]] bool fits(std::span<const std::uint32_t> ring,
                          std::span<const Vec3> ring_positions);
  // Applies the collapse that was accepted last.
  void commit(std::span<const std::uint32_t> ring);

  // Returns the largest distance certified for that collapse.
  [[nodiscard]] double largest_of_last() const { return fan_.largest(); }
  // Returns an upper bound of all distances, except for rounding.
  [[nodiscard]] double largest() const { return largest_; }

  [[nodiscard]] bool is_carried(std::uint32_t vertex) const { return is_carried_[vertex] != 0; }
  // Returns the current map, in which every edge of N is an edge of the map; `numbers` are the
  // numbers of N's triangles there.
  [[nodiscard]] StoredMapping map(std::span<const std::uint32_t> numbers) const;

 private:
  static constexpr std::uint32_t kNone = CollapsingMesh::kNone;
  static constexpr std::uint32_t kFanEdge = kNone;
  // Its square is finite.
  static constexpr double kLargestLimit = 1e150;
  // Added to `last_collapse` for vertices of the ring, which stay. No surface has this many
  // attempts.
  static constexpr std::uint32_t kRingOffset = std::uint32_t{1} << 31;
  // A range of the fan's triangles.
  struct Sectors {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
  };
  struct Vertex {
    // The next vertex carried by the same triangle.
    std::uint32_t next_carried = kNone;
    // The last collapse whose fan contains it.
    std::uint32_t last_collapse = 0;
    // Its position in that fan.
    Sectors sectors;
  };
  // An edge of the original surface, as seen from one of its ends. The half at the low end
  // identifies the edge.
  struct HalfEdge {
    // The vertex at the other end.
    std::uint32_t other = 0;
    // The half edge at that vertex.
    std::uint32_t twin = 0;
    // The first crossing from this end.
    std::uint32_t first = kNone;
  };
  // An edge of the simplified surface.
  struct Edge {
    // Head of the list of crossings on it.
    std::uint32_t crossed = kNone;
    // The last collapse that touched it.
    std::uint32_t last_collapse = 0;
    // Its place in that collapse: kFanEdge, or i for the edge from w_i to w_(i+1).
    std::uint32_t place = 0;
  };
  struct Crossing {
    // The low half; kNone for a deleted crossing.
    std::uint32_t half = kNone;
    // The crossed edge.
    std::uint32_t on = kNone;
    // The neighbors along the original edge.
    std::uint32_t previous = kNone, next = kNone;
    // The next crossing in the list of `on`.
    std::uint32_t next_on = kNone;
    std::uint32_t last_collapse = 0;
  };
  // A segment of an original edge inside the ring, in order from the low end.
  struct OverlaySegment {
    std::uint32_t half = 0;
    std::uint32_t before = kNone, after = kNone;  // Crossings of the ring, or kNone at an end.
    std::uint32_t from = 0, to = 0;               // Sectors.
  };

  void number_edges();
  void add_edges(const StoredMapping& map, std::span<const std::uint32_t> parts);
  void add_crossings(const StoredMapping& map);
  [[nodiscard]] bool measure(std::span<const std::uint32_t> ring,
                             std::span<const Vec3> ring_positions, double limit);
  [[nodiscard]] bool measure_locally(std::span<const std::uint32_t> ring,
                                     std::span<const Vec3> ring_positions);
  [[nodiscard]] bool measure_rim(std::span<const std::uint32_t> ring,
                                 std::span<const Vec3> ring_positions);
  void include(std::uint32_t vertex);
  // Returns the ends of the edge with this low half.
  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> ends(std::uint32_t half) const {
    return {halves_[halves_[half].twin].other, halves_[half].other};
  }
  [[nodiscard]] bool place(std::uint32_t vertex);
  void mark(std::span<const std::uint32_t> ring);
  [[nodiscard]] bool find_segments_of_vertices();
  [[nodiscard]] bool find_passing_segments(std::span<const std::uint32_t> ring);
  // Adds a segment of the edge with this low half, from `low` to `high`.
  [[nodiscard]] bool add_segment(std::uint32_t half, std::uint32_t low, std::uint32_t high,
                                 std::uint32_t before, std::uint32_t after, bool had_crossings);
  [[nodiscard]] Sectors sectors_at(std::uint32_t crossing, std::uint32_t vertex) const;
  void commit_segment(const OverlaySegment& segment, std::span<const std::uint32_t> ring);
  [[nodiscard]] bool is_fan_edge(std::uint32_t edge) const {
    return edges_[edge].last_collapse == collapse_number_ && edges_[edge].place == kFanEdge;
  }

  const CollapsingMesh& mesh_;
  std::span<const CollapseFan::Point> points_;
  const PieceLimit& limit_;
  std::vector<Edge> edges_;
  std::vector<std::uint32_t> edge_of_;       // By opposite corner.
  std::vector<std::uint32_t> halves_begin_;  // By vertex.
  std::vector<HalfEdge> halves_;
  std::vector<Vertex> vertices_;
  std::vector<std::uint8_t> is_carried_;
  // The first vertex that each triangle carries.
  std::vector<std::uint32_t> first_carried_;
  std::vector<Crossing> crossings_;
  std::uint32_t free_ = kNone;
  double largest_ = 0;

  // State of one collapse.
  std::uint32_t collapse_number_ = 0;
  CollapseFan fan_;
  std::vector<std::uint32_t> placed_;
  std::vector<OverlaySegment> segments_;
  // For limits that vary: a box around all that lies in the fan, and the largest error in it.
  Box region_ = {};
  double largest_error_ = 0;
};

}  // namespace multitetra
