#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "server/core/sampling/field_probe.hpp"
#include "server/core/sampling/slice_pixels.hpp"
#include "server/core/sampling/vertex_scalars.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/make_dataset.hpp"

namespace multitetra::testing {
namespace {

// A sheared, stretched and rotated map whose world coordinates are far from the sample indices.
Affine oblique() {
  return {.columns = {Vec3{0.4, 0.3, 0}, Vec3{-0.6, 0.8, 0.1}, Vec3{0.2, 0.5, 2}},
          .translation = {10, -20, 30}};
}

// Requires whole-numbered coordinates.
double sample(const Volume& volume, const Vec3& p) {
  const std::size_t at =
      volume.index(static_cast<std::int32_t>(p[0]), static_cast<std::int32_t>(p[1]),
                   static_cast<std::int32_t>(p[2]));
  return std::visit([at](const auto& samples) { return static_cast<double>(samples[at]); },
                    volume.samples);
}

std::vector<float> pixels(const PreparedVolume& volume, const SliceRequest& slice) {
  const SliceRequest plane = in_indices(slice, volume.info);
  std::vector<float> values(plane.pixels());
  slice_rows(volume, plane, slice_spacing(plane, volume.info), 0, plane.height, values);
  return values;
}

// A slice of the samples with index `index` along `axis`, one pixel per sample.
SliceRequest layer(const DatasetInfo& info, std::size_t axis, int index) {
  const std::size_t right = axis == 0 ? 1 : 0;
  const std::size_t down = axis == 2 ? 1 : 2;
  SliceRequest slice{.coordinates = CoordinateSystem::kIndex,
                     .right = {0, 0, 0},
                     .down = {0, 0, 0},
                     .width = static_cast<std::uint32_t>(info.dims[right]),
                     .height = static_cast<std::uint32_t>(info.dims[down])};
  slice.origin[axis] = index;
  slice.right[right] = 1;
  slice.down[down] = 1;
  return slice;
}

SliceRequest in_world(SliceRequest slice, const DatasetInfo& info) {
  const Affine& map = info.index_to_world;
  const auto step = [&](const Vec3& v) { return difference(map(v), map.translation); };
  slice.coordinates = CoordinateSystem::kWorld;
  slice.origin = map(slice.origin);
  slice.right = step(slice.right);
  slice.down = step(slice.down);
  slice.inward = step(slice.inward);
  return slice;
}

template <typename Sample>
Volume random_volume() {
  std::mt19937_64 random(7);
  Volume volume = fields::sampled<Sample>({37, 18, 33}, [&](int, int, int) {
    constexpr double kLow = std::is_signed_v<Sample> ? -127 : 0;
    return std::floor(kLow + 255 * fields::uniform(random)) * (sizeof(Sample) > 1 ? 127.0 : 1.0);
  });
  volume.index_to_world = oblique();
  return volume;
}

template <typename Sample>
void expect_layers_are_the_samples() {
  const Volume volume = random_volume<Sample>();
  const DatasetPtr dataset = make_dataset(volume, "noise", std::nullopt, 3);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const std::int32_t at : {0, 7, 16, dataset->info.dims[axis] - 1}) {
      for (const Interpolation how : {Interpolation::kNearest, Interpolation::kLinear}) {
        SliceRequest slice = layer(dataset->info, axis, at);
        slice.interpolation = how;
        const std::vector<float> by_index = pixels(*dataset, slice);
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < by_index.size(); ++i) {
          const auto column = static_cast<double>(i % slice.width);
          const auto row = static_cast<double>(i / slice.width);
          const Vec3 p = moved(moved(slice.origin, column, slice.right), row, slice.down);
          const double is = sample(volume, p);
          if (static_cast<double>(by_index[i]) != is) ++wrong;
        }
        EXPECT_EQ(wrong, 0U) << "axis " << axis << " at " << at;
        EXPECT_EQ(pixels(*dataset, in_world(slice, dataset->info)), by_index)
            << "axis " << axis << " at " << at << " from the world";
      }
    }
  }
}

TEST(Slice, EqualsTheSamplesAlongAnAxis) {
  expect_layers_are_the_samples<std::uint8_t>();
  expect_layers_are_the_samples<std::int8_t>();
  expect_layers_are_the_samples<std::uint16_t>();
  expect_layers_are_the_samples<std::int16_t>();
  expect_layers_are_the_samples<float>();
}

Volume slope() {
  Volume volume = fields::sampled<float>(
      {37, 29, 42}, [](int x, int y, int z) { return 3.0 * x + 2.0 * y - z + 100; });
  volume.index_to_world = oblique();
  return volume;
}

TEST(Slice, IsExactForLinearFieldsInAnyDirection) {
  const DatasetPtr dataset = make_dataset(slope(), "slope", std::nullopt, 0);
  const SliceRequest slice{.coordinates = CoordinateSystem::kIndex,
                           .origin = {-5.3, 2.2, 30.1},
                           .right = {0.71, 0.13, -0.2},
                           .down = {0.05, 0.4, 0.33},
                           .width = 70,
                           .height = 60};
  std::size_t inside = 0;
  const std::vector<float> values = pixels(*dataset, slice);
  for (std::uint32_t row = 0; row < slice.height; ++row) {
    for (std::uint32_t column = 0; column < slice.width; ++column) {
      const Vec3 p = moved(moved(slice.origin, column, slice.right), row, slice.down);
      const bool is_inside =
          p[0] >= 0 && p[0] <= 36 && p[1] >= 0 && p[1] <= 28 && p[2] >= 0 && p[2] <= 41;
      const float value = values[std::size_t{row} * slice.width + column];
      EXPECT_EQ(!std::isnan(value), is_inside);
      if (!is_inside) continue;
      ++inside;
      EXPECT_NEAR(static_cast<double>(value), 3 * p[0] + 2 * p[1] - p[2] + 100, 1e-4);
    }
  }
  EXPECT_GT(inside, 1000U);
}

TEST(Slice, IsTheSameInPieces) {
  const DatasetPtr dataset = make_dataset(random_volume<std::uint8_t>(), "noise", std::nullopt, 0);
  const SliceRequest slice{.coordinates = CoordinateSystem::kIndex,
                           .origin = {0, 0, 5},
                           .right = {0.3, 0.01, 0.1},
                           .down = {0, 0.2, 0.1},
                           .width = 90,
                           .height = 50};
  const std::vector<float> whole = pixels(*dataset, slice);
  std::vector<float> pieces(whole.size());
  for (std::uint32_t row = 0; row < slice.height; row += 7) {
    const std::uint32_t rows = std::min(7U, slice.height - row);
    slice_rows(*dataset, slice, 1, row, rows, pieces);
  }
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_TRUE(whole[i] == pieces[i] || (std::isnan(whole[i]) && std::isnan(pieces[i])));
  }
}

TEST(Slice, RowsAlongXAreThoseOfTheTransposedSlice) {
  const DatasetPtr dataset = make_dataset(random_volume<std::int16_t>(), "noise", std::nullopt, 0);
  for (const double step : {1.0, 2.0, 3.0, 20.0, 0.5}) {
    SliceRequest slice = layer(dataset->info, 2, 1);
    slice.origin = {1, 2, 5};
    slice.height = 40;
    slice.right = {step, 0, 0};
    slice.down = {0, 1, 0};
    slice.detail = SliceDetail::kFull;
    for (slice.width = 40; slice.width > 0; slice.width /= 3) {  // Some are beyond the data.
      SliceRequest transposed = slice;
      std::swap(transposed.right, transposed.down);
      std::swap(transposed.width, transposed.height);
      const std::vector<float> rows = pixels(*dataset, slice);
      const std::vector<float> columns = pixels(*dataset, transposed);
      for (std::uint32_t i = 0; i < slice.width * slice.height; ++i) {
        const float value = columns[i % slice.width * slice.height + i / slice.width];
        EXPECT_TRUE(rows[i] == value || (std::isnan(rows[i]) && std::isnan(value))) << step;
      }
    }
  }
}

TEST(Slice, LayersAreSlicesBehindEachOther) {
  const DatasetPtr dataset = make_dataset(random_volume<std::int16_t>(), "noise", std::nullopt, 0);
  SliceRequest box = layer(dataset->info, 2, 1);
  box.width = 12;
  box.height = 6;
  box.right = {3, 0, 0};
  box.down = {0, 3, 0};
  box.inward = {0, 0, 3};
  box.layers = 10;
  box.detail = SliceDetail::kFull;
  for (const SliceRequest& request : {box, in_world(box, dataset->info)}) {
    const std::vector<float> found = pixels(*dataset, request);
    std::vector<float> expected;
    for (std::uint32_t k = 0; k < box.layers; ++k) {
      SliceRequest one = box;
      one.origin[2] += 3.0 * k;
      one.layers = 1;
      const std::vector<float> values = pixels(*dataset, one);
      expected.insert(expected.end(), values.begin(), values.end());
    }
    EXPECT_EQ(found, expected);
  }
}

TEST(Slice, IsVoidOnlyWhereAVoidSampleHasWeight) {
  Volume volume = fields::sampled<float>({9, 9, 9}, [](int x, int, int) { return x; });
  std::get<std::vector<float>>(volume.samples)[volume.index(4, 4, 4)] = std::nanf("");
  const DatasetPtr dataset = make_dataset(std::move(volume), "hole", std::nullopt, 0);
  const auto value_at = [&](Vec3 place) {
    return pixels(*dataset, {.coordinates = CoordinateSystem::kIndex, .origin = place}).front();
  };
  EXPECT_TRUE(std::isnan(value_at({4, 4, 4})));
  EXPECT_TRUE(std::isnan(value_at({3.5, 4, 4})));
  EXPECT_EQ(value_at({3, 4, 4}), 3);
  EXPECT_EQ(value_at({3.5, 3, 4}), 3.5F);
}

TEST(Slice, UsesEveryEighthSampleForCoarsePixels) {
  const Volume volume = random_volume<std::uint16_t>();
  const DatasetPtr dataset = make_dataset(volume, "noise", std::nullopt, 3);
  SliceRequest slice{.coordinates = CoordinateSystem::kIndex,
                     .origin = {5, 5, 13},
                     .right = {8, 0, 0},
                     .down = {0, 8, 0},
                     .width = 4,
                     .height = 2};
  EXPECT_EQ(slice_spacing(slice, dataset->info), 8);
  const std::vector<float> values = pixels(*dataset, slice);
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 4; ++column) {
      EXPECT_EQ(static_cast<double>(values[static_cast<std::size_t>(4 * row + column)]),
                sample(volume, {5.0 + 8 * column, 5.0 + 8 * row, 13}));
    }
  }
  // The field also continues between the outermost of these samples and the end of the data.
  slice.origin = {0, 0, 0};
  EXPECT_EQ(static_cast<double>(pixels(*dataset, slice).front()), sample(volume, {5, 5, 5}));
  slice.detail = SliceDetail::kFull;
  EXPECT_EQ(slice_spacing(slice, dataset->info), 1);
  slice.detail = SliceDetail::kAuto;
  slice.right = {3.9, 0, 0};
  EXPECT_EQ(slice_spacing(slice, dataset->info), 1);
}

TEST(Slice, StaysWithinTheLimitForHugeVolumes) {
  DatasetInfo info;
  info.dims = {16385, 16385, 16385};
  info.grid_exponent = 14;
  std::mt19937_64 random(3);
  for (int i = 0; i < 200; ++i) {
    SliceRequest plane{.coordinates = CoordinateSystem::kIndex, .width = 2048, .height = 1024};
    for (Vec3* step : {&plane.right, &plane.down}) {
      for (double& part : *step) part = 20 * fields::uniform(random) - 10;
    }
    const bool is_coarse = slice_spacing(plane, info) == 8;
    EXPECT_TRUE(is_coarse || bricks_crossed(plane, info) <= kMaxSliceBricks);
  }
  SliceRequest whole = layer(info, 2, 100);
  EXPECT_EQ(slice_spacing(whole, info), 8);
}

TEST(Probe, ReturnsValueAndWorldGradientOfALinearField) {
  const DatasetPtr dataset = make_dataset(slope(), "slope", std::nullopt, 0);
  const Affine map = dataset->info.index_to_world;
  for (const Vec3& index : {Vec3{3.25, 4.5, 5.125}, Vec3{0, 28, 41}, Vec3{36, 0, 0}}) {
    const ProbedPlace by_index = probed(*dataset, CoordinateSystem::kIndex, index);
    const ProbedPlace by_world = probed(*dataset, CoordinateSystem::kWorld, map(index));
    for (const ProbedPlace& place : {by_index, by_world}) {
      ASSERT_TRUE(place.value && place.gradient);
      EXPECT_NEAR(*place.value, 3 * index[0] + 2 * index[1] - index[2] + 100, 1e-9);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(place.index[axis], index[axis], 1e-12);
        EXPECT_NEAR(place.world[axis], map(index)[axis], 1e-12);
        // A step along a column of the map leads to the next sample.
        const double by_a_sample = dot(*place.gradient, map.columns[axis]);
        EXPECT_NEAR(by_a_sample, (Vec3{3, 2, -1})[axis], 1e-9);
      }
    }
  }
  const ProbedPlace beyond = probed(*dataset, CoordinateSystem::kIndex, {-0.1, 0, 0});
  EXPECT_FALSE(beyond.value || beyond.gradient);
}

// A square with sides of 4 grid steps in the plane z = 3, as two triangles.
LatticeMesh square() {
  return {.resolution = 5,
          .vertices = {{64, 64, 96}, {192, 64, 96}, {192, 192, 96}, {64, 192, 96}},
          .triangles = {{0, 1, 2}, {0, 2, 3}}};
}

TEST(VertexScalars, HaveNoDeviationForALinearField) {
  const DatasetPtr dataset = make_dataset(slope(), "slope", std::nullopt, 0);
  // The surface's grid coordinates are half the field's sample indices.
  const Affine halves = {.columns = {Vec3{0.5, 0, 0}, Vec3{0, 0.5, 0}, Vec3{0, 0, 0.5}},
                         .translation = {1, 2, 3}};
  const Affine map = composed(dataset->info.index_to_world, halves);
  const VertexScalars scalars = vertex_scalars(*dataset, square(), map);
  EXPECT_LT(scalars.largest_deviation, 1e-9);
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 at = halves(grid_coordinates(square().vertices[i], 5));
    EXPECT_NEAR(scalars.values[i], 3 * at[0] + 2 * at[1] - at[2] + 100, 1e-9);
  }
}

TEST(VertexScalars, BoundTheInterpolationError) {
  const Volume parabola = fields::sampled<float>({9, 9, 9}, [](int x, int, int) { return x * x; });
  const DatasetPtr dataset = make_dataset(parabola, "parabola", std::nullopt, 0);
  const VertexScalars scalars = vertex_scalars(*dataset, square(), {});
  EXPECT_EQ(scalars.values, (std::vector<double>{4, 36, 36, 4}));
  // At the middle of the diagonal, x = 4, the field is 16 but interpolation gives 20. Border edges
  // have no second triangle to compare with.
  EXPECT_EQ(scalars.largest_deviation, 4);
  const Affine beside = {.columns = Affine{}.columns, .translation = {5, 0, 0}};
  const VertexScalars half = vertex_scalars(*dataset, square(), beside);
  EXPECT_EQ(half.values[0], 49);
  EXPECT_TRUE(std::isnan(half.values[1]));
}

}  // namespace
}  // namespace multitetra::testing
