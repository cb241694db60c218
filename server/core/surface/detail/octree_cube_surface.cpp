#include "server/core/surface/detail/octree_cube_surface.hpp"

#include <algorithm>
#include <bit>

#include "server/core/surface/marching_tetrahedra.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kCenter = 13;

struct TableTetrahedron {
  std::array<std::uint8_t, 4> corners{};
  std::array<std::uint8_t, 6>
      edges{};               // Indices in Table::edges, in the order of kTetrahedronEdges.
  bool is_negative = false;  // The sign of its volume in a cube without mirroring.
  std::uint32_t mask = 0;    // Bit mask of the corners.
};

// The ends of an edge of a tetrahedron in the table.
using TableEdge = std::array<std::uint8_t, 2>;

// The tetrahedra at one edge of a face whose center is kept.
struct FaceEdge {
  std::size_t middle = 0;
  TableTetrahedron whole;             // If the edge's midpoint is not kept.
  std::array<std::size_t, 2> ends{};  // Otherwise, one half at each end whose child is not refined:
  std::array<TableTetrahedron, 2> halves;
};

struct Face {
  std::size_t center = 0;
  std::uint32_t mask = 0;                 // All its points and the cube's center.
  std::array<TableTetrahedron, 2> uncut;  // If the center is not kept.
  std::array<FaceEdge, 4> edges;
};

constexpr GridPoint place(std::size_t index) {
  const auto i = static_cast<std::int32_t>(index);
  return {i % 3, i / 3 % 3, i / 9};
}

// Numbers edges in the order of their first appearance.
struct EdgeList {
  std::array<TableEdge, 128> edges{};
  std::size_t count = 0;

  constexpr std::uint8_t number(std::uint8_t i, std::uint8_t j) {
    const TableEdge edge = {std::min(i, j), std::max(i, j)};
    std::size_t at = 0;
    while (at < count && edges[at] != edge) ++at;
    if (at == count) edges[count++] = edge;
    return static_cast<std::uint8_t>(at);
  }
};

struct Table {
  std::array<Face, 6> faces;
  EdgeList edges;
};

constexpr TableTetrahedron tetrahedron(EdgeList& edges, std::size_t a, std::size_t b, std::size_t c,
                                       std::size_t d) {
  TableTetrahedron result{
      .corners = {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b),
                  static_cast<std::uint8_t>(c), static_cast<std::uint8_t>(d)},
      .is_negative = six_times_volume(place(a), place(b), place(c), place(d)) < 0,
      .mask = 1U << a | 1U << b | 1U << c | 1U << d};
  for (std::size_t i = 0; i < 6; ++i) {
    const auto [p, q] = kTetrahedronEdges[i];
    result.edges[i] = edges.number(result.corners[p], result.corners[q]);
  }
  return result;
}

constexpr Table make_table() {
  constexpr std::array<std::size_t, 3> kStride = {1, 3, 9};
  Table table{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const std::size_t side : {std::size_t{0}, std::size_t{2}}) {
      const std::size_t u = kStride[(axis + 1) % 3];
      const std::size_t v = kStride[(axis + 2) % 3];
      const std::size_t origin = side * kStride[axis];
      Face& face = table.faces[2 * axis + side / 2];
      face.center = origin + u + v;
      for (std::size_t i = 0; i < 9; ++i) face.mask |= 1U << (origin + i % 3 * u + i / 3 * v);
      face.mask |= 1U << kCenter;
      // The split edge runs from corner a to corner b.
      const std::size_t a = origin;
      const std::size_t b = origin + 2 * u + 2 * v;
      const std::array<std::size_t, 4> ring = {a, origin + 2 * u, b, origin + 2 * v};
      face.uncut = {tetrahedron(table.edges, a, b, ring[1], kCenter),
                    tetrahedron(table.edges, a, b, ring[3], kCenter)};
      for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t p = ring[i];
        const std::size_t q = ring[(i + 1) % 4];
        FaceEdge& edge = face.edges[i];
        edge.middle = (p + q) / 2;
        edge.whole = tetrahedron(table.edges, p, q, face.center, kCenter);
        edge.ends = {p, q};
        edge.halves = {tetrahedron(table.edges, p, edge.middle, face.center, kCenter),
                       tetrahedron(table.edges, q, edge.middle, face.center, kCenter)};
      }
    }
  }
  return table;
}
constexpr Table kTable = make_table();

// Calls `visit` for the cube's own tetrahedra at a face.
template <typename Visit>
void visit_tetrahedra(const Face& face, std::uint32_t kept, const Visit& visit) {
  const auto is_kept = [kept](std::size_t point) { return (kept >> point & 1U) != 0; };
  if (!is_kept(face.center)) {
    visit(face.uncut[0]);
    visit(face.uncut[1]);
    return;
  }
  for (const FaceEdge& edge : face.edges) {
    if (!is_kept(edge.middle)) {
      visit(edge.whole);
      continue;
    }
    for (std::size_t end = 0; end < 2; ++end) {
      if (!is_kept(edge.ends[end])) visit(edge.halves[end]);
    }
  }
}

constexpr std::uint32_t bits_of_points_with(int middles) {
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < 27; ++i) {
    const GridPoint at = place(i);
    if ((at.x == 1) + (at.y == 1) + (at.z == 1) == middles) bits |= 1U << i;
  }
  return bits;
}

// The maximum number of tetrahedra that an octree cube has of its own.
constexpr std::size_t kMaxTetrahedra = 48;

// Returns the number of the cube's own tetrahedra: twelve, and two more for every face cut in four
// and for every edge cut in two (whose faces are then cut). A refined child removes six; the three
// edges at its corner are cut, as their midpoints are parents of its center.
std::uint32_t count_tetrahedra(std::uint32_t kept) {
  constexpr std::uint32_t kCorners = bits_of_points_with(0);
  constexpr std::uint32_t kFacesAndEdges = bits_of_points_with(1) | bits_of_points_with(2);
  return 12 + 2 * static_cast<std::uint32_t>(std::popcount(kept & kFacesAndEdges)) -
         6 * static_cast<std::uint32_t>(std::popcount(kept & kCorners));
}

// The vertices in one cube, each looked up once.
class CubeVertices {
 public:
  CubeVertices(const OctreeCubePoints& points, EdgeVertices& known, double isovalue, int resolution,
               std::vector<LatticePoint>& vertices)
      : points_(points),
        known_(known),
        isovalue_(isovalue),
        resolution_(resolution),
        vertices_(vertices) {
    numbers_.fill(EdgeVertices::kNone);
  }

  // Returns the number of the vertex on an edge of the table.
  [[nodiscard]] std::uint32_t on(std::size_t edge) {
    const std::uint32_t number = numbers_[edge];
    return number != EdgeVertices::kNone ? number : find(edge);
  }

 private:
  // Not inlined, to keep the frequent case of an existing vertex short.
  [[gnu::noinline]] std::uint32_t find(std::size_t edge) {
    const auto [i, j] = kTable.edges.edges[edge];
    std::uint32_t& number = numbers_[edge];
    // No other cube has edges to the center of a smallest cube.
    const bool is_inside = points_.step == 1 && (i == kCenter || j == kCenter);
    std::uint32_t& slot = is_inside ? number : known_.at(points_.sum_of_ends(i, j));
    if (slot == EdgeVertices::kNone) {
      slot = static_cast<std::uint32_t>(vertices_.size());
      vertices_.push_back(lattice_vertex(points_.at(i), static_cast<double>(points_.values[i]),
                                         points_.at(j), static_cast<double>(points_.values[j]),
                                         isovalue_, resolution_));
    }
    return number = slot;
  }

  const OctreeCubePoints& points_;
  EdgeVertices& known_;
  double isovalue_;
  int resolution_;
  std::vector<LatticePoint>& vertices_;
  std::array<std::uint32_t, kTable.edges.count> numbers_;
};

}  // namespace

OctreeCubePoints points_of(const OctreeCube& cube) {
  OctreeCubePoints points;
  points.step = cube.side() / 2;
  const auto middle = [&](std::int32_t position) { return position * cube.side() + points.step; };
  points.center = {middle(cube.x), middle(cube.y), middle(cube.z)};
  const auto turn = [](std::int32_t position) { return (position & 1) == 0 ? 1 : -1; };
  points.turned = {turn(cube.x), turn(cube.y), turn(cube.z)};
  return points;
}

OctreeCubeSurface::Counts OctreeCubeSurface::append(const OctreeCubePoints& points,
                                                    EdgeVertices& known, LatticeMesh& mesh) const {
  std::uint32_t positive = 0;
  std::uint32_t is_void = 0;
  for (std::size_t i = 0; i < 27; ++i) {
    const float value = points.values[i];
    positive |= static_cast<std::uint32_t>(value > isovalue_below_) << i;
    is_void |= static_cast<std::uint32_t>(value != value) << i;
  }
  constexpr std::uint32_t kAll = (1U << 27) - 1;
  Counts counts{.tetrahedra = count_tetrahedra(points.kept)};
  if (positive == 0 || (positive | is_void) == kAll) return counts;

  CubeVertices vertices(points, known, isovalue_, resolution_, mesh.vertices);
  std::array<TriangleIndices, 2 * kMaxTetrahedra> triangles;
  std::size_t count = 0;
  const bool is_turned = points.turned[0] * points.turned[1] * points.turned[2] < 0;
  for (const Face& face : kTable.faces) {
    const std::uint32_t face_signs = positive & face.mask;
    if (face_signs == 0 || (face_signs | (is_void & face.mask)) == face.mask) continue;
    visit_tetrahedra(face, points.kept, [&](const TableTetrahedron& t) {
      const std::uint32_t signs = positive & t.mask;
      if (signs == 0 || signs == t.mask || (is_void & t.mask) != 0) return;
      ++counts.active_tetrahedra;
      unsigned corner_signs = 0;
      for (std::size_t i = 0; i < 4; ++i) corner_signs |= (positive >> t.corners[i] & 1U) << i;
      const MarchingCase& c = kMarchingCases[corner_signs][t.is_negative != is_turned ? 1 : 0];
      const std::uint32_t p = vertices.on(t.edges[c.edges[0]]);
      const std::uint32_t q = vertices.on(t.edges[c.edges[1]]);
      const std::uint32_t r = vertices.on(t.edges[c.edges[2]]);
      if (c.corners == 3) {
        triangles[count++] = {p, q, r};
        return;
      }
      const std::uint32_t s = vertices.on(t.edges[c.edges[3]]);
      const auto& at = mesh.vertices;
      const bool along_first = is_cut_along_first(at[p], at[q], at[r], at[s]);
      triangles[count++] = along_first ? TriangleIndices{p, q, r} : TriangleIndices{q, r, s};
      triangles[count++] = along_first ? TriangleIndices{p, r, s} : TriangleIndices{q, s, p};
    });
  }
  mesh.triangles.insert(mesh.triangles.end(), triangles.begin(),
                        triangles.begin() + static_cast<std::ptrdiff_t>(count));
  return counts;
}

}  // namespace multitetra
