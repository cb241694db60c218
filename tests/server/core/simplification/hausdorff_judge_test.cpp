// Checks the bound with CGAL's Hausdorff distance over all points, where other tests use samples,
// and the intersecting triangles.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/distance.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "server/core/simplification/simplification.hpp"
#include "tests/support/lattice_intersections.hpp"
#include "tests/support/simplifying.hpp"

namespace multitetra::testing {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using CgalPoint = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
using CgalMesh = CGAL::Surface_mesh<CgalPoint>;

CgalMesh cgal_mesh_of(const LatticeMesh& mesh, const Vec3& step) {
  std::vector<CgalPoint> points;
  for (const LatticePoint& p : mesh.vertices) {
    points.emplace_back(step[0] * p.x, step[1] * p.y, step[2] * p.z);
  }
  std::vector<std::vector<std::size_t>> triangles;
  for (const TriangleIndices& t : mesh.triangles) triangles.push_back({t[0], t[1], t[2]});
  // Where surfaces touch themselves, at void samples, vertices are duplicated in place.
  if (!pmp::is_polygon_soup_a_polygon_mesh(triangles)) pmp::orient_polygon_soup(points, triangles);
  CgalMesh result;
  pmp::polygon_soup_to_polygon_mesh(points, triangles, result);
  return result;
}

class HausdorffJudge : public SimplificationGuarantees {};
// The small settings: CGAL takes a thousand times as long as the simplification it checks.
std::vector<Setting> judged_settings() {
  std::vector<Setting> some = settings();
  std::erase_if(some, [](const Setting& setting) {
    const std::string_view name = setting.name;
    return name != "closed_noise" && name != "flat_noise" && name != "ball" &&
           name != "masked_gyroid";
  });
  return some;
}
INSTANTIATE_TEST_SUITE_P(Fields, HausdorffJudge, ::testing::ValuesIn(judged_settings()),
                         [](const auto& parameter) { return parameter.param.name; });

TEST_P(HausdorffJudge, FindsNoPointFartherThanTheBound) {
  const CgalMesh full = cgal_mesh_of(surface_.mesh, step_);
  for (const double max_distance : {0.25, 1.0}) {
    SCOPED_TRACE(max_distance);
    const Simplified small =
        simplified(surface_.mesh, {.lattice_step = step_, .max_distance = max_distance});
    const CgalMesh coarse = cgal_mesh_of(small.mesh, step_);
    const double exactness = 0.01 * max_distance;
    const auto distance = [&](const CgalMesh& from, const CgalMesh& to) {
      return pmp::bounded_error_Hausdorff_distance<CGAL::Sequential_tag>(from, to, exactness);
    };
    const double away = distance(coarse, full);
    const double back = distance(full, coarse);
    EXPECT_LE(away, small.bound + exactness);
    EXPECT_LE(back, small.bound + exactness);
    // The distance is not trivially zero: simplification moved something.
    EXPECT_GT(std::max(away, back), exactness);
  }
}

// Without surfaces that touch themselves: the judge is given doubled vertices there, which
// intersect.
class IntersectionJudge : public SimplificationGuarantees {};
std::vector<Setting> untouching_settings() {
  std::vector<Setting> some = judged_settings();
  std::erase_if(some, [](const Setting& setting) {
    return std::string_view(setting.name) == "masked_gyroid";
  });
  return some;
}
INSTANTIATE_TEST_SUITE_P(Fields, IntersectionJudge, ::testing::ValuesIn(untouching_settings()),
                         [](const auto& parameter) { return parameter.param.name; });

TEST_P(IntersectionJudge, FindsExactlyTheIntersectingPairs) {
  std::size_t pairs = 0;
  for (const bool is_intersection_free : {false, true}) {
    for (const double max_distance : {0.5, 4.0}) {
      SCOPED_TRACE(max_distance);
      const Simplified small =
          simplified(surface_.mesh, {.lattice_step = step_,
                                     .max_distance = max_distance,
                                     .is_intersection_free = is_intersection_free});
      const CgalMesh mesh = cgal_mesh_of(small.mesh, {1, 1, 1});
      std::vector<std::pair<CgalMesh::Face_index, CgalMesh::Face_index>> found;
      pmp::self_intersections(mesh, std::back_inserter(found));
      EXPECT_EQ(lattice_intersections(small.mesh).pairs, found.size());
      if (is_intersection_free) {
        EXPECT_EQ(found.size(), 0U);
      }
      pairs += found.size();
    }
  }
  if (std::string_view(setting_.name) == "closed_noise") {
    EXPECT_GT(pairs, 0U) << "Nothing is at stake.";
  }
}

}  // namespace
}  // namespace multitetra::testing
