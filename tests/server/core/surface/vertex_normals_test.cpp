#include "server/core/surface/vertex_normals.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "tests/support/fields.hpp"
#include "tests/support/make_dataset.hpp"

namespace multitetra::testing {
namespace {

constexpr int kResolution = 5;
constexpr double kPi = 3.14159265358979323846;

// Random places between the first and the last sample, at least `inset` grid steps inside.
std::vector<LatticePoint> places(const DatasetInfo& info, std::int32_t inset, std::size_t count) {
  std::mt19937_64 random(5);
  const auto coordinate = [&](std::size_t axis) {
    const std::int32_t low = (info.margin + inset) << kResolution;
    const std::int32_t high = (info.margin + info.dims[axis] - 1 - inset) << kResolution;
    const double at = low + fields::uniform(random) * (high - low + 1);
    // Like vertices, some lie on planes of the grid.
    const auto v = static_cast<std::int32_t>(at);
    return fields::uniform(random) < 0.3 ? v >> kResolution << kResolution : v;
  };
  std::vector<LatticePoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t x = coordinate(0);
    const std::int32_t y = coordinate(1);
    points.push_back({x, y, coordinate(2)});
  }
  return points;
}

double degrees_between(const UnitVector& a, const Vec3& b) {
  double dot = 0;
  double square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    dot += static_cast<double>(a[axis]) * b[axis];
    square += b[axis] * b[axis];
  }
  return std::acos(std::min(1.0, dot / std::sqrt(square))) * 180 / kPi;
}

// Returns the largest angle to `expected`, a function of sample index coordinates.
template <typename Direction>
double largest_angle(const DatasetPtr& dataset, const std::vector<LatticePoint>& points,
                     NormalSource source, const Direction& expected) {
  const std::vector<UnitVector> normals = vertex_normals(*dataset, points, kResolution, source);
  EXPECT_EQ(normals.size(), points.size());
  double largest = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_TRUE(is_unit(normals[i]));
    Vec3 at = grid_coordinates(points[i], kResolution);
    for (double& coordinate : at) coordinate -= dataset->info.margin;
    largest = std::max(largest, degrees_between(normals[i], expected(at)));
  }
  return largest;
}

Volume plane() {
  return fields::sampled<float>({37, 29, 42},
                                [](int x, int y, int z) { return 3.0 * x + 2.0 * y - z + 1e4; });
}

// A sheared, stretched and rotated map.
Affine oblique() {
  return {.columns = {Vec3{0.4, 0.3, 0}, Vec3{-0.6, 0.8, 0.1}, Vec3{0.2, 0.5, 2}},
          .translation = {10, -20, 30}};
}

TEST(VertexNormals, AreExactForAPlaneUpToTheBorder) {
  const DatasetPtr dataset = make_dataset(plane(), "plane", std::nullopt, 3);
  const auto falls = [](const Vec3&) { return Vec3{-3, -2, 1}; };
  const auto points = places(dataset->info, 0, 3000);
  EXPECT_LT(largest_angle(dataset, points, NormalSource::kSamples, falls), 0.05);
  const auto inner = places(dataset->info, 8, 3000);
  EXPECT_LT(largest_angle(dataset, inner, NormalSource::kCoarseSamples, falls), 0.05);
}

TEST(VertexNormals, ArePerpendicularInAnyCoordinates) {
  for (const bool mirrored : {false, true}) {
    Volume volume = plane();
    volume.index_to_world = oblique();
    if (mirrored) {
      for (double& entry : volume.index_to_world.columns[1]) entry = -entry;
    }
    const DatasetPtr dataset = make_dataset(volume, "plane");
    // Perpendicular to two directions in which the field is constant, and towards lower values.
    const auto along = [&](const Vec3& index) {
      const Vec3 from = volume.index_to_world({0, 0, 0});
      const Vec3 to = volume.index_to_world(index);
      return Vec3{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
    };
    const auto points = places(dataset->info, 1, 100);
    for (const UnitVector& n :
         vertex_normals(*dataset, points, kResolution, NormalSource::kSamples)) {
      const auto degrees = [&n](const Vec3& v) { return degrees_between(n, v); };
      EXPECT_NEAR(degrees(along({1, 0, 3})), 90, 0.05);
      EXPECT_NEAR(degrees(along({0, 1, 2})), 90, 0.05);
      EXPECT_LT(degrees(along({-1, 0, 0})), 90);
    }
  }
}

TEST(VertexNormals, PointAwayFromTheMiddleOfABall) {
  const DatasetPtr dataset = make_dataset(fields::ball({41, 41, 41}, 12), "ball");
  std::vector<LatticePoint> points;
  for (const LatticePoint& p : places(dataset->info, 2, 3000)) {
    const Vec3 at = grid_coordinates(p, kResolution);
    if (std::hypot(at[0] - 20, at[1] - 20, at[2] - 20) > 8) points.push_back(p);
  }
  ASSERT_GT(points.size(), 1000U);
  const auto outwards = [](const Vec3& at) { return Vec3{at[0] - 20, at[1] - 20, at[2] - 20}; };
  EXPECT_LT(largest_angle(dataset, points, NormalSource::kSamples, outwards), 0.5);
}

TEST(VertexNormals, FollowTheGradientOfAGyroid) {
  const DatasetPtr dataset = make_dataset(fields::gyroid(65, 0, 1), "gyroid");
  const double k = 4 * kPi / 64;
  const auto sin = [k](double v) { return std::sin(k * v); };
  const auto cos = [k](double v) { return std::cos(k * v); };
  const auto falls = [&](const Vec3& p) {
    return Vec3{sin(p[2]) * sin(p[0]) - cos(p[0]) * cos(p[1]),
                sin(p[0]) * sin(p[1]) - cos(p[1]) * cos(p[2]),
                sin(p[1]) * sin(p[2]) - cos(p[2]) * cos(p[0])};
  };
  std::vector<LatticePoint> points;  // Near the surface of value 0, where the gradient is large.
  for (const LatticePoint& p : places(dataset->info, 1, 9000)) {
    const Vec3 at = grid_coordinates(p, kResolution);
    const double value =
        sin(at[0]) * cos(at[1]) + sin(at[1]) * cos(at[2]) + sin(at[2]) * cos(at[0]);
    if (std::abs(value) < 0.3) points.push_back(p);
  }
  ASSERT_GT(points.size(), 1000U);
  EXPECT_LT(largest_angle(dataset, points, NormalSource::kSamples, falls), 1.0);
}

TEST(VertexNormals, AreIndependentOfOtherVertices) {
  for (const auto& outside : {std::optional<double>(), std::optional<double>(0.25)}) {
    const DatasetPtr dataset = make_dataset(fields::masked_gyroid(37, 3), "masked", outside, 2);
    const auto points = places(dataset->info, 0, 1000);
    for (const NormalSource source : {NormalSource::kSamples, NormalSource::kCoarseSamples}) {
      const auto together = vertex_normals(*dataset, points, kResolution, source);
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_TRUE(is_unit(together[i]));
        EXPECT_EQ(vertex_normals(*dataset, {&points[i], 1}, kResolution, source).front(),
                  together[i]);
      }
    }
  }
}

TEST(VertexNormals, IgnoreVoidSamples) {
  Volume volume = plane();
  auto& samples = std::get<std::vector<float>>(volume.samples);
  for (int z = 0; z < volume.dims[2]; z += 3) {
    for (int y = 0; y < volume.dims[1]; y += 3) {
      for (int x = 0; x < volume.dims[0]; x += 3) {
        samples[volume.index(x, y, z)] = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }
  const DatasetPtr dataset = make_dataset(volume, "holes");
  const auto falls = [](const Vec3&) { return Vec3{-3, -2, 1}; };
  std::vector<LatticePoint> points = places(dataset->info, 2, 3000);
  // At a void sample there is no other sample to interpolate from.
  std::erase_if(points, [](const LatticePoint& p) {
    return ((p.x | p.y | p.z) & ((1 << kResolution) - 1)) == 0;
  });
  EXPECT_LT(largest_angle(dataset, points, NormalSource::kSamples, falls), 0.05);
}

TEST(VertexNormals, UseTheOutsideValue) {
  const Volume block = fields::sampled<std::uint8_t>({3, 3, 3}, [](int, int, int) { return 9; });
  const DatasetPtr dataset = make_dataset(block, "block", 0.0, 2);
  const std::int32_t middle = 3 << kResolution;
  const std::vector<LatticePoint> points = {{middle, middle, middle - 40},
                                            {middle + 40, middle, middle}};
  EXPECT_EQ(vertex_normals(*dataset, points, kResolution, NormalSource::kSamples),
            (std::vector<UnitVector>{{0, 0, -1}, {1, 0, 0}}));
}

TEST(VertexNormals, PointUpForZeroGradients) {
  const Volume flat = fields::sampled<std::int16_t>({9, 9, 9}, [](int, int, int) { return -4; });
  const Volume empty = fields::sampled<float>({9, 9, 9}, [](int x, int y, int z) {
    return x + y + z == 0 ? 1.0 : std::numeric_limits<double>::quiet_NaN();
  });
  const std::vector<LatticePoint> points = {{100, 128, 90}};
  for (const Volume& volume : {flat, empty}) {
    const DatasetPtr dataset = make_dataset(volume, "none");
    for (const NormalSource source : {NormalSource::kSamples, NormalSource::kCoarseSamples}) {
      EXPECT_EQ(vertex_normals(*dataset, points, kResolution, source).front(), kNoDirection);
    }
  }
}

TEST(VertexNormals, AreUnitVectorsForTheLargestFloats) {
  const Volume steep =
      fields::sampled<float>({9, 9, 9}, [](int x, int, int) { return x < 4 ? -3e38 : 3e38; });
  const DatasetPtr dataset = make_dataset(steep, "steep");
  const std::vector<LatticePoint> points = {{112, 128, 90}};
  EXPECT_EQ(vertex_normals(*dataset, points, kResolution, NormalSource::kSamples).front(),
            (UnitVector{-1, 0, 0}));
}

struct Unreadable : BrickSource {
  [[nodiscard]] RetainedBytes brick(std::size_t) const override {
    throw std::runtime_error("a brick was read");
  }
};

TEST(VertexNormals, ReadNoBrickForCoarseSamples) {
  const DatasetPtr dataset = make_dataset(plane(), "plane");
  PreparedVolume coarse_only = *dataset;
  coarse_only.samples = std::make_shared<const Unreadable>();
  const auto points = places(dataset->info, 8, 100);
  EXPECT_EQ(vertex_normals(coarse_only, points, kResolution, NormalSource::kCoarseSamples),
            vertex_normals(*dataset, points, kResolution, NormalSource::kCoarseSamples));
  EXPECT_THROW((void)vertex_normals(coarse_only, points, kResolution, NormalSource::kSamples),
               std::runtime_error);
}

}  // namespace
}  // namespace multitetra::testing
