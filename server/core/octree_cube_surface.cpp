#include "server/core/octree_cube_surface.hpp"

#include <algorithm>

#include "server/core/marching_tetrahedra.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kCentre = 13;

struct TableTetrahedron {
  std::array<std::uint8_t, 4> corners{};
  bool is_negative = false;  // Its volume's sign in a cube that is not turned.
  std::uint32_t mask = 0;    // The corners as bits.
};

// What lies at one edge of a face, when the face's centre is kept.
struct FaceEdge {
  std::size_t middle = 0;
  TableTetrahedron whole;             // When the edge's midpoint is not kept.
  std::array<std::size_t, 2> ends{};  // Otherwise, at each end whose child is not refined:
  std::array<TableTetrahedron, 2> halves;
};

struct Face {
  std::size_t centre = 0;
  std::uint32_t mask = 0;                 // All its points and the cube's centre.
  std::array<TableTetrahedron, 2> uncut;  // When the centre is not kept.
  std::array<FaceEdge, 4> edges;
};

constexpr GridPoint place(std::size_t index) {
  const auto i = static_cast<std::int32_t>(index);
  return {i % 3, i / 3 % 3, i / 9};
}

constexpr TableTetrahedron tetrahedron(std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
  return {.corners = {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b),
                      static_cast<std::uint8_t>(c), static_cast<std::uint8_t>(d)},
          .is_negative = six_volumes(place(a), place(b), place(c), place(d)) < 0,
          .mask = 1U << a | 1U << b | 1U << c | 1U << d};
}

constexpr std::array<Face, 6> make_faces() {
  constexpr std::array<std::size_t, 3> kStride = {1, 3, 9};
  std::array<Face, 6> faces{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const std::size_t side : {std::size_t{0}, std::size_t{2}}) {
      const std::size_t u = kStride[(axis + 1) % 3];
      const std::size_t v = kStride[(axis + 2) % 3];
      const std::size_t origin = side * kStride[axis];
      Face& face = faces[2 * axis + side / 2];
      face.centre = origin + u + v;
      for (std::size_t i = 0; i < 9; ++i) face.mask |= 1U << (origin + i % 3 * u + i / 3 * v);
      face.mask |= 1U << kCentre;
      // The split edge runs from corner a to corner b.
      const std::size_t a = origin;
      const std::size_t b = origin + 2 * u + 2 * v;
      const std::array<std::size_t, 4> ring = {a, origin + 2 * u, b, origin + 2 * v};
      face.uncut = {tetrahedron(a, b, ring[1], kCentre), tetrahedron(a, b, ring[3], kCentre)};
      for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t p = ring[i];
        const std::size_t q = ring[(i + 1) % 4];
        FaceEdge& edge = face.edges[i];
        edge.middle = (p + q) / 2;
        edge.whole = tetrahedron(p, q, face.centre, kCentre);
        edge.ends = {p, q};
        edge.halves = {tetrahedron(p, edge.middle, face.centre, kCentre),
                       tetrahedron(q, edge.middle, face.centre, kCentre)};
      }
    }
  }
  return faces;
}
constexpr std::array<Face, 6> kFaces = make_faces();

// Calls `visit` for the cube's own tetrahedra at a face.
template <typename Visit>
void visit_tetrahedra(const Face& face, std::uint32_t kept, const Visit& visit) {
  const auto is_kept = [kept](std::size_t point) { return (kept >> point & 1U) != 0; };
  if (!is_kept(face.centre)) {
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

// How many there are.
std::uint32_t count_tetrahedra(const Face& face, std::uint32_t kept) {
  if ((kept >> face.centre & 1U) == 0) return 2;
  std::uint32_t count = 4;
  for (const FaceEdge& edge : face.edges) {
    const std::uint32_t refined = (kept >> edge.ends[0] & 1U) + (kept >> edge.ends[1] & 1U);
    if ((kept >> edge.middle & 1U) != 0) count += 1 - refined;
  }
  return count;
}

}  // namespace

OctreeCubePoints points_of(const OctreeCube& cube) {
  OctreeCubePoints points;
  points.step = cube.side() / 2;
  const auto middle = [&](std::int32_t position) { return position * cube.side() + points.step; };
  points.centre = {middle(cube.x), middle(cube.y), middle(cube.z)};
  const auto turn = [](std::int32_t position) { return (position & 1) == 0 ? 1 : -1; };
  points.turned = {turn(cube.x), turn(cube.y), turn(cube.z)};
  return points;
}

OctreeCubeSurface::Counts OctreeCubeSurface::append(const OctreeCubePoints& points,
                                                    std::vector<LatticeTriangle>& triangles) {
  std::uint32_t positive = 0;
  std::uint32_t is_void = 0;
  for (std::size_t i = 0; i < 27; ++i) {
    const float value = points.values[i];
    positive |= static_cast<std::uint32_t>(value > isovalue_below_) << i;
    is_void |= static_cast<std::uint32_t>(value != value) << i;
  }
  ++cube_;
  Counts counts;
  const bool is_turned = points.turned[0] * points.turned[1] * points.turned[2] < 0;
  for (const Face& face : kFaces) {
    counts.tetrahedra += count_tetrahedra(face, points.kept);
    const std::uint32_t face_signs = positive & face.mask;
    if (face_signs == 0 || (face_signs | (is_void & face.mask)) == face.mask) continue;
    visit_tetrahedra(face, points.kept, [&](const TableTetrahedron& t) {
      const std::uint32_t signs = positive & t.mask;
      if (signs == 0 || signs == t.mask || (is_void & t.mask) != 0) return;
      ++counts.active_tetrahedra;
      unsigned corner_signs = 0;
      for (std::size_t i = 0; i < 4; ++i) corner_signs |= (positive >> t.corners[i] & 1U) << i;
      const TetrahedronSurface surface = march(
          kMarchingCases[corner_signs], t.is_negative != is_turned,
          [&](std::size_t i, std::size_t j) { return vertex(points, t.corners[i], t.corners[j]); });
      triangles.push_back(surface.triangles[0]);
      if (surface.count == 2) triangles.push_back(surface.triangles[1]);
    });
  }
  return counts;
}

LatticePoint OctreeCubeSurface::vertex(const OctreeCubePoints& points, std::size_t i,
                                       std::size_t j) {
  Known& known = known_[std::min(i, j) + 27 * std::max(i, j)];
  if (known.cube != cube_) {
    known.cube = cube_;
    known.vertex = lattice_vertex(points.at(i), static_cast<double>(points.values[i]), points.at(j),
                                  static_cast<double>(points.values[j]), isovalue_, resolution_);
  }
  return known.vertex;
}

}  // namespace multitetra
