#include "common/mesh/mesh.hpp"

#include <algorithm>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "common/mesh/content_digest.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "tests/support/surfaces.hpp"

namespace multitetra {
namespace {

// The border is far away: every open edge is a crack.
constexpr DataBorder kNoBorder{.low = {0, 0, 0}, .high = {1 << 20, 1 << 20, 1 << 20}};

std::vector<LatticeTriangle> corners(const LatticeMesh& mesh) {
  std::vector<LatticeTriangle> result;
  for (const TriangleIndices& t : mesh.triangles) {
    result.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
  }
  return result;
}

// ---- index_triangles, weld, positioned

TEST(IndexTriangles, ListsEveryVertexOnceInOrderOfAppearance) {
  const std::vector<LatticeTriangle> triangles = {{LatticePoint{5, 5, 5}, {6, 5, 5}, {5, 6, 5}},
                                                  {LatticePoint{6, 5, 5}, {6, 6, 5}, {5, 6, 5}}};
  const LatticeMesh mesh = index_triangles(triangles, 4);
  EXPECT_EQ(mesh.resolution, 4);
  EXPECT_EQ(mesh.vertices, (std::vector<LatticePoint>{{5, 5, 5}, {6, 5, 5}, {5, 6, 5}, {6, 6, 5}}));
  EXPECT_EQ(mesh.triangles, (std::vector<TriangleIndices>{{0, 1, 2}, {1, 3, 2}}));
}

TEST(IndexTriangles, KeepsDegenerateAndDuplicateTriangles) {
  std::mt19937 random(1);
  const std::int32_t end = std::int32_t{1} << kMaxLatticeBits;
  for (const std::int32_t spread : {2, 40, end}) {
    std::uniform_int_distribution<std::int32_t> coordinate(0, spread);
    std::vector<LatticeTriangle> triangles(3000);
    for (LatticeTriangle& t : triangles) {
      for (LatticePoint& p : t) p = {coordinate(random), coordinate(random), coordinate(random)};
    }
    const LatticeMesh mesh = index_triangles(triangles, 5);
    EXPECT_EQ(corners(mesh), triangles);
    EXPECT_EQ(std::set<LatticePoint>(mesh.vertices.begin(), mesh.vertices.end()).size(),
              mesh.vertices.size());
  }
}

TEST(IndexTriangles, ReturnsAnEmptyMeshForNoTriangles) {
  const LatticeMesh mesh = index_triangles({}, 5);
  EXPECT_TRUE(mesh.vertices.empty());
  EXPECT_TRUE(mesh.triangles.empty());
}

TEST(Weld, JoinsPieces) {
  const LatticeMesh whole = surfaces::torus(5, 24, 12, 0.2, 1);
  const std::vector<LatticeTriangle> triangles = corners(whole);
  std::vector<LatticeMesh> pieces;
  for (std::size_t at = 0; at < triangles.size(); at += 37) {
    pieces.push_back(index_triangles(
        std::span(triangles).subspan(at, std::min<std::size_t>(37, triangles.size() - at)), 5));
  }
  const LatticeMesh welded = weld(pieces, 5);
  EXPECT_EQ(welded.vertices, whole.vertices);
  EXPECT_EQ(welded.triangles, whole.triangles);
  EXPECT_EQ(topology(welded, kNoBorder), topology(whole, kNoBorder));
}

TEST(Weld, ReturnsAnEmptyMeshForNoTriangles) {
  const LatticeMesh mesh = weld(std::vector<LatticeMesh>(), 6);
  EXPECT_EQ(mesh.resolution, 6);
  EXPECT_TRUE(mesh.vertices.empty());
}

TEST(InCanonicalOrder, DependsOnlyOnTheTriangles) {
  const std::vector<LatticeTriangle> triangles = {{LatticePoint{0, 0, 0}, {4, 0, 0}, {0, 4, 0}},
                                                  {LatticePoint{4, 0, 0}, {4, 4, 0}, {0, 4, 0}},
                                                  {LatticePoint{4, 4, 0}, {0, 4, 4}, {0, 4, 0}}};
  const std::vector<LatticeTriangle> turned = {{triangles[2][1], triangles[2][2], triangles[2][0]},
                                               {triangles[0][2], triangles[0][0], triangles[0][1]},
                                               triangles[1]};
  LatticeMesh one = index_triangles(triangles, 5);
  LatticeMesh other = index_triangles(turned, 5);
  ASSERT_NE(one.vertices, other.vertices);
  for (LatticeMesh* mesh : {&one, &other}) {
    for (const LatticePoint& p : mesh->vertices) {
      mesh->scalars.push_back(static_cast<float>(p.key()));
      mesh->normals.push_back({static_cast<float>(p.x), static_cast<float>(p.y), 0});
    }
  }
  const LatticeMesh a = in_canonical_order(one);
  const LatticeMesh b = in_canonical_order(other);
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.scalars, b.scalars);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(digest(a), digest(one));
  EXPECT_EQ(in_canonical_order(a).triangles, a.triangles);
}

TEST(Positioned, FlipsTrianglesOnlyInMirroredWorlds) {
  const LatticeMesh mesh = index_triangles(
      std::vector<LatticeTriangle>{{LatticePoint{32, 64, 0}, {0, 32, 0}, {0, 0, 32}}}, 5);
  Affine map{.translation = {10, 20, 30}};
  EXPECT_EQ(positioned(mesh, map).positions[0], (Vec3{11, 22, 30}));
  EXPECT_EQ(positioned(mesh, map).triangles, mesh.triangles);
  map.columns[1] = {0, -2, 0};
  EXPECT_EQ(positioned(mesh, map).positions[0], (Vec3{11, 16, 30}));
  EXPECT_EQ(positioned(mesh, map).triangles[0], (TriangleIndices{0, 2, 1}));
}

// ---- topology

TEST(Topology, HasEulerCharacteristicZeroForATorus) {
  const MeshTopology found = topology(surfaces::torus(5, 24, 12, 0.2, 1), kNoBorder);
  EXPECT_EQ(found, (MeshTopology{.vertices = 288,
                                 .edges = 864,
                                 .triangles = 576,
                                 .euler_characteristic = 0,
                                 .components = 1}));
  EXPECT_TRUE(found.is_sound());
}

TEST(Topology, CountsComponentsAndSumsEulerCharacteristics) {
  const LatticePoint middle = surfaces::center(5);
  std::vector<LatticeTriangle> apart = surfaces::octahedron(middle, 4);
  for (const LatticeTriangle& t : surfaces::octahedron({middle.x + 9, middle.y, middle.z}, 4)) {
    apart.push_back(t);
  }
  const MeshTopology two = topology(index_triangles(apart, 5), kNoBorder);
  EXPECT_EQ(two.components, 2);
  EXPECT_EQ(two.euler_characteristic, 4);
  EXPECT_TRUE(two.is_sound());
  const MeshTopology touching = topology(surfaces::touching_octahedra(5), kNoBorder);
  EXPECT_EQ(touching.components, 1);
  EXPECT_EQ(touching.euler_characteristic, 3);
  EXPECT_TRUE(touching.is_sound()) << "two fans at a vertex share no edge";
}

TEST(Topology, ReportsAHoleInsideTheDataAsACrack) {
  LatticeMesh mesh = surfaces::torus(5, 24, 12, 0.2, 1);
  mesh.triangles.pop_back();
  const MeshTopology found = topology(mesh, kNoBorder);
  EXPECT_EQ(found.open_edges, 3);
  EXPECT_EQ(found.border_edges, 0);
  EXPECT_FALSE(found.is_sound());
}

TEST(Topology, AllowsTheSurfaceToEndOnlyOnTheBorder) {
  // A triangle with two corners on x = 0.
  const LatticeMesh mesh = index_triangles(
      std::vector<LatticeTriangle>{{LatticePoint{0, 8, 8}, {0, 16, 8}, {8, 8, 16}}}, 3);
  const DataBorder border{.low = {0, 0, 0}, .high = {64, 64, 64}};
  EXPECT_EQ(topology(mesh, border).border_edges, 1);
  EXPECT_EQ(topology(mesh, border).open_edges, 2);
  const DataBorder wider{.low = {0, 0, 0}, .high = {64, 64, 64}, .inset = 8};
  EXPECT_EQ(topology(mesh, wider).border_edges, 3);
  const DataBorder anywhere{.low = {}, .high = {64, 64, 64}, .inset = 0, .anywhere = true};
  EXPECT_TRUE(topology(mesh, anywhere).is_sound());
}

TEST(Topology, FindsTheBorderOnEachOfTheSixFaces) {
  const DataBorder border{.low = {8, 16, 24}, .high = {40, 48, 56}};
  const LatticePoint a = {20, 30, 40};
  const LatticePoint b = {22, 33, 44};
  EXPECT_FALSE(border.contains_edge(a, b));
  const auto with = [](LatticePoint p, int axis, std::int32_t value) {
    (axis == 0 ? p.x : axis == 1 ? p.y : p.z) = value;
    return p;
  };
  const std::array<std::array<std::int32_t, 2>, 3> faces = {{{8, 40}, {16, 48}, {24, 56}}};
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = faces[static_cast<std::size_t>(axis)];
    EXPECT_TRUE(border.contains_edge(with(a, axis, low), with(b, axis, low)));
    EXPECT_TRUE(border.contains_edge(with(a, axis, high), with(b, axis, high)));
    EXPECT_FALSE(border.contains_edge(with(a, axis, low + 1), with(b, axis, low + 1)));
    EXPECT_FALSE(border.contains_edge(with(a, axis, high - 1), with(b, axis, high - 1)));
    EXPECT_FALSE(border.contains_edge(with(a, axis, low), with(b, axis, high)));
    EXPECT_FALSE(border.contains_edge(with(a, axis, low), b));
  }
}

TEST(Topology, FindsInconsistentOrientation) {
  LatticeMesh mesh = surfaces::torus(5, 24, 12, 0.2, 1);
  std::swap(mesh.triangles[7][0], mesh.triangles[7][1]);
  EXPECT_EQ(topology(mesh, kNoBorder).nonmanifold_edges, 3);
}

TEST(Topology, FindsAnEdgeOfThreeTriangles) {
  std::vector<LatticeTriangle> triangles = surfaces::octahedron(surfaces::center(5), 4);
  const LatticePoint far = surfaces::low_corner(5);
  triangles.push_back({triangles[0][0], triangles[0][1], far});
  const MeshTopology found = topology(index_triangles(triangles, 5), kNoBorder);
  EXPECT_EQ(found.nonmanifold_edges, 1);
  EXPECT_EQ(found.open_edges, 2);
}

TEST(Topology, CountsTheEdgesOfAnyFan) {
  // Around vertex 0, from few to so many that comparing each spoke with all would take minutes.
  for (const std::uint32_t spokes : {3U, 40U, 70U, 500'000U}) {
    std::vector<TriangleIndices> fan;
    for (std::uint32_t i = 0; i < spokes; ++i) fan.push_back({0, 1 + i, 1 + (i + 1) % spokes});
    const auto nowhere = [](std::uint32_t, std::uint32_t) { return false; };
    const MeshTopology found = topology(spokes + 1, fan, nowhere);
    EXPECT_EQ(found.edges, 2 * spokes);
    EXPECT_EQ(found.open_edges, spokes);
    EXPECT_EQ(found.nonmanifold_edges, 0);
    fan.push_back({0, 1, spokes + 1});  // One spoke more, and a third triangle at another.
    EXPECT_EQ(topology(spokes + 2, fan, nowhere).nonmanifold_edges, 1) << spokes;
  }
}

TEST(Topology, CountsDegenerateTrianglesWithoutTheirEdges) {
  for (const TriangleIndices& degenerate :
       {TriangleIndices{3, 3, 9}, TriangleIndices{9, 3, 3}, TriangleIndices{3, 9, 3}}) {
    LatticeMesh mesh = surfaces::torus(5, 24, 12, 0.2, 1);
    mesh.triangles.push_back(degenerate);
    const MeshTopology found = topology(mesh, kNoBorder);
    EXPECT_EQ(found.degenerate_triangles, 1);
    EXPECT_EQ(found.open_edges, 0);
    EXPECT_FALSE(found.is_sound());
  }
}

TEST(Topology, IsZeroAndValidForAnEmptyMesh) {
  EXPECT_EQ(topology(LatticeMesh{}, kNoBorder), MeshTopology{});
  EXPECT_TRUE(MeshTopology{}.is_sound());
}

// ---- content digest

TEST(ContentDigest, IsIndependentOfTriangleOrderAndTiling) {
  const LatticeMesh mesh = surfaces::torus(5, 24, 12, 0.2, 1);
  std::vector<LatticeTriangle> triangles = corners(mesh);
  std::shuffle(triangles.begin(), triangles.end(), std::mt19937(3));
  for (LatticeTriangle& t : triangles) std::rotate(t.begin(), t.begin() + 1, t.end());
  EXPECT_EQ(digest(index_triangles(triangles, 5)), digest(mesh));
  ContentDigest sum;
  for (const LatticeTriangle& t : triangles) sum += digest(t, 5);
  EXPECT_EQ(sum, digest(mesh));
}

TEST(ContentDigest, ChangesWithEveryVertex) {
  const LatticeTriangle t = {LatticePoint{1, 2, 3}, {4, 5, 6}, {7, 8, 10}};
  const ContentDigest original = digest(t, 5);
  EXPECT_NE(digest(t, 4), original) << "resolution";
  EXPECT_NE(digest({t[0], t[2], t[1]}, 5), original) << "outside";
  for (std::size_t corner = 0; corner < 3; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      LatticeTriangle changed = t;
      ++(axis == 0 ? changed[corner].x : axis == 1 ? changed[corner].y : changed[corner].z);
      EXPECT_NE(digest(changed, 5), original);
    }
  }
}

TEST(ContentDigest, MatchesTheDocumentedDigestOfOneTriangle) {
  // Clients store digests between connections, so a change here changes the protocol.
  const LatticeTriangle t = {LatticePoint{1, 2, 3}, {4, 5, 6}, {7, 8, 10}};
  EXPECT_EQ(digest(t, 5).hex(), "6b5514e8adff4fe31f714a6516d4c88d");
}

TEST(ContentDigest, ReadsOnlyItsOwnHex) {
  const ContentDigest value{0x0123456789abcdef, 0x00000000000000ff};
  EXPECT_EQ(value.hex(), "0123456789abcdef00000000000000ff");
  EXPECT_EQ(ContentDigest::from_hex(value.hex()), value);
  for (const char* wrong :
       {"", "0123456789abcdef00000000000000f", "0123456789ABCDEF00000000000000ff",
        "0123456789abcdef00000000000000fg", "-123456789abcdef00000000000000ff",
        "0123456789abcdef00000000000000ff0"}) {
    EXPECT_EQ(ContentDigest::from_hex(wrong), std::nullopt) << wrong;
  }
}

}  // namespace
}  // namespace multitetra
