// Compares the full surface with its definition (tests/support/full_resolution_surface.hpp).
#include "server/certify/detail/reference_surface.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/full_resolution_surface.hpp"
#include "tests/support/prepared_fields.hpp"

namespace multitetra {
namespace {

namespace fields = testing::fields;
using testing::PreparedSetting;

std::vector<float> samples_of(const Volume& volume) {
  return std::visit([](const auto& s) { return std::vector<float>(s.begin(), s.end()); },
                    volume.samples);
}

ReferenceSurface reference_of(const Volume& volume, double isovalue,
                              std::optional<double> outside = std::nullopt,
                              std::int32_t margin = 0) {
  return reference_surface(Field(volume, outside, margin), grid_info(volume, outside, margin),
                           isovalue);
}

double area(const std::vector<SurfaceTriangle>& surface) {
  double area = 0;
  for (const SurfaceTriangle& t : surface) {
    area += 0.5 * length(cross(difference(t[1], t[0]), difference(t[2], t[0])));
  }
  return area;
}

TEST(ReferenceSurface, IsAPlaneForALinearField) {
  const Volume volume = fields::sampled<float>(
      {9, 7, 12}, [](int x, int y, int z) { return 2 * x + 3 * y + 6 * z; }, {1, 2, 0.5});
  const ReferenceSurface surface = reference_of(volume, 30.25);
  ASSERT_FALSE(surface.mesh.triangles.empty());
  for (const Vec3& p : surface.mesh.vertices) {
    ASSERT_NEAR(2 * p[0] + 1.5 * p[1] + 12 * p[2], 30.25, 1e-12);
  }
}

// The tetrahedra fill the data and do not overlap.
TEST(ReferenceSurface, HasTheAreaOfAPlane) {
  for (const std::array<std::int32_t, 3> dims :
       {std::array<std::int32_t, 3>{9, 9, 9}, {8, 6, 7}, {17, 3, 2}}) {
    const Volume volume = fields::sampled<float>(dims, [](int x, int, int) { return x; });
    EXPECT_NEAR(area(triangles_of(reference_of(volume, 0.3).mesh)), (dims[1] - 1) * (dims[2] - 1),
                1e-9)
        << dims[0];
  }
}

TEST(ReferenceSurface, EndsAtVoidAndClosesAtAValue) {
  const Volume volume = fields::sampled<float>({5, 5, 5}, [](int, int, int) { return 1; });
  EXPECT_TRUE(reference_of(volume, 0.5).mesh.triangles.empty());
  const ReferenceSurface closed = reference_of(volume, 0.5, 0.0, 1);
  EXPECT_GT(area(triangles_of(closed.mesh)), 6 * 4 * 4);
  EXPECT_LE(area(triangles_of(closed.mesh)), 6 * 5 * 5 + 1e-9);
  EXPECT_EQ(closed.topology.components, 1);
  EXPECT_EQ(closed.topology.euler_characteristic, 2);
  EXPECT_EQ(closed.topology.border_edges, 0);
}

class ReferenceSurfaceEveryField : public ::testing::TestWithParam<PreparedSetting> {};

// Compares areas and distances, as quadrangles may be split along either diagonal.
TEST_P(ReferenceSurfaceEveryField, MatchesTheDefinition) {
  const PreparedSetting& setting = GetParam();
  const DatasetInfo info = grid_info(setting.volume, setting.outside, setting.margin);
  const auto samples = samples_of(setting.volume);
  const DatasetPtr dataset = testing::prepared(setting);
  for (const double isovalue : testing::isovalues_of(*dataset)) {
    SCOPED_TRACE(isovalue);
    const auto expected = testing::full_resolution_surface(info, samples, isovalue);
    const ReferenceSurface found =
        reference_of(setting.volume, isovalue, setting.outside, setting.margin);
    EXPECT_TRUE(found.topology.is_sound());
    ASSERT_EQ(found.mesh.triangles.size(), expected.size());
    std::vector<Vec3> positions;
    for (const SurfaceTriangle& t : expected) positions.insert(positions.end(), t.begin(), t.end());
    std::vector<Vec3> own = found.mesh.vertices;
    const auto make_set = [](std::vector<Vec3>& all) {
      for (Vec3& p : all) {  // Rounded, to be equal from either end of an edge.
        for (double& v : p) v = std::round(v * 0x1p30);
      }
      std::sort(all.begin(), all.end());
      all.erase(std::unique(all.begin(), all.end()), all.end());
    };
    make_set(positions);
    make_set(own);
    ASSERT_EQ(own.size(), positions.size());
    for (std::size_t i = 0; i < own.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_NEAR(own[i][axis], positions[i][axis], 4);
      }
    }
    const double whole = area(expected);
    EXPECT_NEAR(area(triangles_of(found.mesh)), whole, 1e-6 * (1 + whole));
  }
}

INSTANTIATE_TEST_SUITE_P(All, ReferenceSurfaceEveryField,
                         ::testing::ValuesIn(testing::prepared_settings()),
                         [](const auto& parameter) { return parameter.param.name; });

}  // namespace
}  // namespace multitetra
