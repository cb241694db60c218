// Compares intersections with CGAL's exact predicates, for triangles on a small lattice, where
// nearly all of them touch, overlap or share vertices.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <gtest/gtest.h>

#include <random>
#include <set>
#include <vector>

#include "common/mesh/detail/triangle_intersection.hpp"
#include "common/mesh/self_intersections.hpp"
#include "tests/support/triangle_meshes.hpp"

namespace multitetra {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalMesh = CGAL::Surface_mesh<Kernel::Point_3>;

Kernel::Point_3 point(const Vec3& p) { return {p[0], p[1], p[2]}; }

TEST(SelfIntersectionsJudge, AgreesOnDisjointTriangles) {
  std::mt19937 random(11);
  std::uniform_int_distribution<int> coordinate(0, 3);
  int meeting = 0;
  int apart = 0;
  while (meeting < 3000 || apart < 3000) {
    std::array<MeshTriangle, 2> pair;
    std::set<Vec3> positions;
    std::uint32_t number = 0;
    for (MeshTriangle& triangle : pair) {
      for (std::size_t i = 0; i < 3; ++i) {
        triangle.vertices[i] = number++;
        triangle.positions[i] = {0.1 * coordinate(random), 1.0 * coordinate(random),
                                 1e3 * coordinate(random)};
        positions.insert(triangle.positions[i]);
      }
    }
    if (positions.size() < 6 || is_flat(pair[0].positions) || is_flat(pair[1].positions)) continue;
    const auto cgal = [](const MeshTriangle& t) {
      return Kernel::Triangle_3(point(t.positions[0]), point(t.positions[1]),
                                point(t.positions[2]));
    };
    const bool expected = CGAL::do_intersect(cgal(pair[0]), cgal(pair[1]));
    ASSERT_EQ(intersect(pair[0], pair[1]), expected);
    ASSERT_EQ(intersect(pair[1], pair[0]), expected);
    ++(expected ? meeting : apart);
  }
}

// Closed meshes whose vertices were moved until the meshes intersect themselves.
TEST(SelfIntersectionsJudge, FindsTheSamePairsInOverlappingSpheres) {
  std::mt19937 random(12);
  for (const double noise : {0.0, 0.1, 0.4}) {
    TriangleMesh mesh =
        testing::joined(testing::sphere({0, 0, 0}, 1, 8), testing::sphere({0.5, 0.25, 0}, 1, 6));
    for (Vec3& vertex : mesh.vertices) {
      for (double& v : vertex) {  // To a lattice: makes many triangles coplanar.
        v = std::round(16 * (v + noise * (static_cast<double>(random() % 1000) / 1000 - 0.5))) / 16;
      }
    }
    mesh = welded(mesh).mesh;
    std::vector<MeshTriangle> triangles;
    for (const TriangleIndices& t : mesh.triangles) {
      const std::array<Vec3, 3> positions = {mesh.vertices[t[0]], mesh.vertices[t[1]],
                                             mesh.vertices[t[2]]};
      if (!is_flat(positions)) triangles.push_back({t, positions});
    }
    CgalMesh judged;
    std::vector<CgalMesh::Vertex_index> vertices;
    for (const Vec3& vertex : mesh.vertices) vertices.push_back(judged.add_vertex(point(vertex)));
    TriangleMesh kept{.vertices = mesh.vertices, .triangles = {}};
    for (const MeshTriangle& t : triangles) {
      const auto face = judged.add_face(vertices[t.vertices[0]], vertices[t.vertices[1]],
                                        vertices[t.vertices[2]]);
      // CGAL rejects faces that would make the mesh non-manifold.
      if (face != CgalMesh::null_face()) kept.triangles.push_back(t.vertices);
    }
    std::vector<std::pair<CgalMesh::Face_index, CgalMesh::Face_index>> pairs;
    pmp::self_intersections(judged, std::back_inserter(pairs));
    const SelfIntersections found = self_intersections(kept);
    EXPECT_EQ(found.pairs, pairs.size()) << noise;
    EXPECT_GT(found.pairs, 50U) << noise;
  }
}

}  // namespace
}  // namespace multitetra
