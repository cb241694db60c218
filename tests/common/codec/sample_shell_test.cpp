// Sample shells decode to what core's marching tetrahedra make of the same samples.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/mesh/content_digest.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/isosurfaces.hpp"
#include "tests/support/sample_shells.hpp"

namespace multitetra {
namespace {

using shell::encode_shell;
using shell::ShellOptions;
using shell::ShellStatus;
using shell::ShellValues;
using testing::box_in;
using testing::boxes_of;
using testing::decode_shell;
using testing::DecodedShell;
using testing::marched;
using testing::OwnedBox;
using testing::quantized;
using testing::sorted_triangles;
namespace fields = testing::fields;

constexpr double kVoid = std::numeric_limits<double>::quiet_NaN();

template <typename Sample>
Volume integers(std::array<std::int32_t, 3> dims, double low, double high, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  // A noisy wave: smooth enough to predict, with ties and plateaus.
  return fields::sampled<Sample>(dims, [&](int x, int y, int z) {
    const double wave = std::sin(0.4 * x) + std::sin(0.3 * y + 1) * std::cos(0.5 * z);
    const double share = 0.5 + 0.2 * wave + 0.1 * (fields::uniform(random) - 0.5);
    return std::floor(low + (high - low) * std::clamp(share, 0.0, 1.0));
  });
}

// Expects every vertex to be used and none to occur twice.
void expect_sound(const LatticeMesh& mesh) {
  std::vector<bool> used(mesh.vertices.size());
  for (const TriangleIndices& t : mesh.triangles) {
    for (const std::uint32_t corner : t) {
      ASSERT_LT(corner, mesh.vertices.size());
      used[corner] = true;
    }
  }
  EXPECT_EQ(std::count(used.begin(), used.end(), false), 0);
  const std::set<LatticePoint> different(mesh.vertices.begin(), mesh.vertices.end());
  EXPECT_EQ(different.size(), mesh.vertices.size());
}

LatticeMesh through_bytes(const OwnedBox& box, const ShellOptions& options) {
  const auto bytes = encode_shell(box.box(), options);
  if (!bytes) {
    ADD_FAILURE() << bytes.error().text;
    return {};
  }
  DecodedShell decoded = decode_shell(*bytes);
  EXPECT_EQ(decoded.status, ShellStatus::kOk);
  return std::move(decoded.mesh);
}

void expect_exact(const OwnedBox& box, const ShellOptions& options) {
  const LatticeMesh mesh = through_bytes(box, options);
  expect_sound(mesh);
  const auto value = [&box](int x, int y, int z) {
    return static_cast<double>(box.value(x, y, z));
  };
  EXPECT_EQ(sorted_triangles(mesh),
            sorted_triangles(marched(box, options.isovalue, options.lattice_resolution,
                                     1 << options.spacing_exponent, value)));
}

// Expects all decoded tiles together to be the volume's surface at a uniform level.
void expect_uniform_surface(const Volume& volume, std::optional<double> outside,
                            std::int32_t margin, int cells, const ShellOptions& options) {
  const Field field(volume, outside, margin);
  const int exponent = field.grid().exponent();
  const UniformModel model(field.grid(), 3 * (exponent - options.spacing_exponent) - 1);
  const testing::Surface surface = testing::surface_of_model(
      model, field, options.isovalue,
      testing::border_of(volume, outside, margin, options.lattice_resolution, 0),
      options.lattice_resolution);
  ContentDigest sum;
  std::size_t triangles = 0;
  for (const OwnedBox& box :
       boxes_of(volume, outside, margin, 1 << options.spacing_exponent, cells)) {
    const LatticeMesh mesh = through_bytes(box, options);
    sum += digest(mesh);
    triangles += mesh.triangles.size();
  }
  EXPECT_EQ(triangles, surface.mesh.triangles.size());
  EXPECT_EQ(sum, digest(surface.mesh));
}

TEST(SampleShell, EqualsTheFinestUniformSurfaceInExactTiles) {
  for (const double isovalue : {100.0, 100.5, 127.25}) {
    for (const int cells : {8, 32, 64}) {
      SCOPED_TRACE(::testing::Message() << isovalue << ", " << cells << " cells");
      const ShellOptions options{.isovalue = isovalue};
      expect_uniform_surface(integers<std::uint8_t>({37, 30, 21}, 0, 256, 1), std::nullopt, 0,
                             cells, options);
      expect_uniform_surface(integers<std::uint8_t>({20, 33, 17}, 0, 256, 2), 0.0, 1, cells,
                             options);
      expect_uniform_surface(integers<std::int8_t>({19, 14, 33}, -128, 128, 3), 120.5, 0, cells,
                             {.isovalue = isovalue - 100});
      expect_uniform_surface(integers<std::uint16_t>({21, 22, 23}, 0, 65536, 4), -1e6, 1, cells,
                             {.isovalue = 256 * isovalue});
      expect_uniform_surface(integers<std::int16_t>({40, 9, 18}, -32768, 32768, 5), std::nullopt, 0,
                             cells, {.isovalue = 256 * (isovalue - 110)});
    }
  }
}

TEST(SampleShell, EqualsTheFinestUniformSurfaceInLatticeExactTiles) {
  const auto options = [](double isovalue, int resolution = 5) {
    return ShellOptions{.isovalue = isovalue,
                        .values = ShellValues::kLatticeExact,
                        .lattice_resolution = resolution};
  };
  for (const int cells : {16, 64}) {
    for (const int resolution : {1, 2, 5, 8}) {
      SCOPED_TRACE(::testing::Message() << cells << " cells, r = " << resolution);
      expect_uniform_surface(fields::gyroid(25, 0.3, 6), std::nullopt, 0, cells,
                             options(0.1, resolution));
      expect_uniform_surface(fields::noise({19, 24, 17}, 7), 0.0, 1, cells,
                             options(0.5, resolution));
      expect_uniform_surface(fields::masked_gyroid(33, 8), std::nullopt, 0, cells,
                             options(0.1, resolution));
      expect_uniform_surface(fields::masked_gyroid(21, 9), 3.0, 1, cells, options(0.1, resolution));
      expect_uniform_surface(fields::ball({33, 20, 27}, 8), -10.0, 0, cells,
                             options(0, resolution));
    }
  }
  // Isovalues equal to integer samples: many samples have distance 0.
  expect_uniform_surface(fields::integer_noise({23, 23, 23}, 4, 10), 0.0, 1, 16, options(1));
  expect_uniform_surface(integers<std::int16_t>({21, 30, 17}, -32768, 32768, 11), std::nullopt, 0,
                         32, options(-77));
}

TEST(SampleShell, EncodesCoarserUniformLevels) {
  for (const int exponent : {1, 2, 3}) {
    SCOPED_TRACE(exponent);
    expect_uniform_surface(integers<std::uint8_t>({70, 61, 50}, 0, 256, 12), std::nullopt, 0, 8,
                           {.isovalue = 128, .spacing_exponent = exponent});
    expect_uniform_surface(integers<std::uint8_t>({70, 61, 50}, 0, 256, 12), 7.0, 1, 16,
                           {.isovalue = 127.5, .spacing_exponent = exponent});
    expect_uniform_surface(
        fields::masked_gyroid(49, 13), std::nullopt, 0, 32,
        {.isovalue = 0.1, .values = ShellValues::kLatticeExact, .spacing_exponent = exponent});
  }
}

TEST(SampleShell, KeepsIntegralFloatsExactly) {
  std::mt19937_64 random(14);
  const Volume volume = fields::sampled<float>({17, 18, 19}, [&](int x, int, int) {
    return x == 3 ? kVoid : std::floor(33554432 * fields::uniform(random)) - 16777216;
  });
  for (const double isovalue : {0.0, 1234.75, -9999999.5}) {
    expect_uniform_surface(volume, std::nullopt, 0, 32, {.isovalue = isovalue});
  }
}

TEST(SampleShell, EqualsTheSurfaceOfTheQuantizedField) {
  for (const int levels : {1, 2, 4, 8}) {
    for (const int resolution : {1, 5, 8}) {
      SCOPED_TRACE(::testing::Message() << levels << " levels, r = " << resolution);
      const auto expect_quantized = [&](const Volume& volume, std::optional<double> outside,
                                        std::int32_t margin, double isovalue, int exponent) {
        for (const OwnedBox& box : boxes_of(volume, outside, margin, 1 << exponent, 32)) {
          const LatticeMesh mesh = through_bytes(box, {.isovalue = isovalue,
                                                       .values = ShellValues::kQuantized,
                                                       .levels_per_octave = levels,
                                                       .lattice_resolution = resolution,
                                                       .spacing_exponent = exponent});
          expect_sound(mesh);
          EXPECT_EQ(
              sorted_triangles(mesh),
              sorted_triangles(marched(box, 0, resolution, 1 << exponent, [&](int x, int y, int z) {
                return quantized(static_cast<double>(box.value(x, y, z)), isovalue, levels);
              })));
        }
      };
      expect_quantized(fields::noise({20, 33, 18}, 15), std::nullopt, 0, 0.5, 0);
      expect_quantized(fields::masked_gyroid(30, 16), -2.0, 1, 0.1, 0);
      expect_quantized(fields::integer_noise({21, 22, 23}, 5, 17), 1.0, 1, 2, 0);
      expect_quantized(integers<std::int16_t>({40, 35, 30}, -2000, 3000, 18), std::nullopt, 0, 17,
                       1);
    }
  }
}

TEST(SampleShell, MovesQuantizedVerticesAtMostByTheBound) {
  const Volume volume = fields::noise({33, 33, 33}, 19);
  const double isovalue = 0.4;
  const OwnedBox box = *box_in(volume, std::nullopt, 0, 1, {0, 0, 0}, {32, 32, 32});
  for (const int levels : {1, 2, 4, 8}) {
    // A cube's diagonal is the longest edge; vertices are rounded to the lattice in both meshes.
    const double of_exact = std::sqrt(3.0) * shell::displacement_bound(levels);
    const double bound = of_exact + std::sqrt(3.0) / 256 + 1e-12;
    const LatticeMesh moved = through_bytes(box, {.isovalue = isovalue,
                                                  .values = ShellValues::kQuantized,
                                                  .levels_per_octave = levels,
                                                  .lattice_resolution = 8});
    const LatticeMesh exact = through_bytes(
        box, {.isovalue = isovalue, .values = ShellValues::kLatticeExact, .lattice_resolution = 8});
    ASSERT_EQ(moved.vertices.size(), exact.vertices.size());
    // Vertices are in the order of their edges, which is the same in both meshes.
    double largest = 0;
    for (std::size_t i = 0; i < moved.vertices.size(); ++i) {
      const LatticePoint& a = moved.vertices[i];
      const LatticePoint& b = exact.vertices[i];
      largest = std::max(largest, std::hypot(a.x - b.x, a.y - b.y, a.z - b.z) / 256);
    }
    EXPECT_LE(largest, bound) << levels;
    EXPECT_GE(largest, 0.9 * of_exact) << levels;
  }
}

TEST(SampleShell, RoundTripsBoxesOfAllSizes) {
  for (std::int32_t cells = 1; cells <= 64; ++cells) {
    for (const auto& dims :
         {std::array{cells + 1, 3, 4}, std::array{2, cells + 1, 5}, std::array{4, 2, cells + 1}}) {
      SCOPED_TRACE(::testing::Message() << dims[0] << " x " << dims[1] << " x " << dims[2]);
      const Volume volume = fields::integer_noise(dims, 7, static_cast<std::uint64_t>(cells));
      for (const std::int32_t origin : {0, 1, 63}) {
        OwnedBox box =
            *box_in(volume, std::nullopt, 0, 1, {0, 0, 0}, {dims[0] - 1, dims[1] - 1, dims[2] - 1});
        box.origin = {origin, 2 * origin, origin + 1};
        expect_exact(box, {.isovalue = 3.5});
        expect_exact(box, {.isovalue = 3, .values = ShellValues::kLatticeExact});
      }
    }
  }
}

TEST(SampleShell, RoundTripsTheLargestBoxes) {
  const auto expect_largest = [](const Volume& volume) {
    const OwnedBox box = *box_in(volume, std::nullopt, 0, 1, {0, 0, 0},
                                 {volume.dims[0] - 1, volume.dims[1] - 1, volume.dims[2] - 1});
    expect_exact(box, {.isovalue = 0.5, .values = ShellValues::kLatticeExact});
  };
  expect_largest(fields::gyroid(65, 0.3, 20));
  expect_largest(fields::noise({65, 65, 7}, 26));
}

TEST(SampleShell, EncodesLayersOnEverySide) {
  const Volume volume = integers<std::uint8_t>({9, 8, 7}, 0, 256, 21);
  for (std::uint32_t layers = 0; layers < 64; ++layers) {
    SCOPED_TRACE(layers);
    OwnedBox box = *box_in(volume, std::nullopt, 0, 1, {0, 0, 0}, {8, 7, 6});
    box.origin = {5, 4, 3};
    box.layers = layers;
    for (const float value : {0.0F, 100.0F, 1e30F, -0.125F}) {
      box.layer_value = value;
      expect_exact(box, {.isovalue = 100});
      expect_exact(box, {.isovalue = 99.75, .values = ShellValues::kLatticeExact});
    }
  }
}

TEST(SampleShell, RoundTripsASingleSampleBetweenLayers) {
  OwnedBox box{.samples = std::vector<std::uint8_t>{7},
               .data_samples = {1, 1, 1},
               .origin = {0, 0, 0},
               .layers = 63,
               .layer_value = 2};
  expect_exact(box, {.isovalue = 4.5});
  expect_exact(box, {.isovalue = 2, .values = ShellValues::kLatticeExact});
}

TEST(SampleShell, HasNoTrianglesWithoutASurface) {
  for (const double value : {-1.0, 0.0, 1.0, kVoid}) {
    const Volume volume =
        fields::sampled<float>({33, 34, 35}, [value](int, int, int) { return value; });
    const OwnedBox box = *box_in(volume, std::nullopt, 0, 1, {0, 0, 0}, {32, 33, 34});
    for (const ShellValues values :
         {ShellValues::kExact, ShellValues::kLatticeExact, ShellValues::kQuantized}) {
      const auto bytes = encode_shell(box.box(), {.isovalue = 0, .values = values});
      ASSERT_TRUE(bytes);
      EXPECT_LT(bytes->size(), 64U);
      const DecodedShell decoded = decode_shell(*bytes);
      EXPECT_EQ(decoded.status, ShellStatus::kOk);
      EXPECT_TRUE(decoded.mesh.triangles.empty());
      EXPECT_TRUE(decoded.mesh.vertices.empty());
    }
  }
}

TEST(SampleShell, RoundTripsExtremeFloats) {
  std::mt19937_64 random(22);
  const Volume volume = fields::sampled<float>({17, 17, 17}, [&](int, int, int) {
    const double sign = fields::uniform(random) < 0.5 ? -1 : 1;
    return sign * std::exp2(270 * fields::uniform(random) - 145);
  });
  const OwnedBox box = *box_in(volume, std::nullopt, 0, 1, {0, 0, 0}, {16, 16, 16});
  expect_exact(box, {.isovalue = 0, .values = ShellValues::kLatticeExact});
  expect_exact(box, {.isovalue = 1e-30, .values = ShellValues::kLatticeExact});
  expect_exact(box, {.isovalue = -1e38, .values = ShellValues::kLatticeExact});
}

TEST(SampleShell, IsDeterministic) {
  const Volume volume = fields::masked_gyroid(33, 23);
  const OwnedBox box = *box_in(volume, std::nullopt, 0, 1, {0, 0, 0}, {32, 32, 32});
  const OwnedBox other =
      *box_in(fields::noise({40, 40, 40}, 24), std::nullopt, 0, 1, {0, 0, 0}, {32, 32, 32});
  const ShellOptions options{.isovalue = 0.1, .values = ShellValues::kLatticeExact};
  shell::ShellEncoder encoder;
  const auto first = encoder.encode(box.box(), options);
  ASSERT_TRUE(encoder.encode(other.box(), options));
  const auto again = encoder.encode(box.box(), options);
  ASSERT_TRUE(first && again);
  EXPECT_EQ(*first, *again);
}

TEST(SampleShellEncoder, RejectsInputBeyondTheFormat) {
  const Volume volume = fields::noise({9, 9, 9}, 25);
  const OwnedBox good = *box_in(volume, std::nullopt, 0, 1, {0, 0, 0}, {8, 8, 8});
  const ShellOptions options{.isovalue = 0.5, .values = ShellValues::kLatticeExact};
  ASSERT_TRUE(encode_shell(good.box(), options));
  const auto refuses = [](const OwnedBox& box, const ShellOptions& requested) {
    const auto bytes = encode_shell(box.box(), requested);
    return !bytes && bytes.error().code == ErrorCode::kInvalidArgument;
  };
  // Fractions are not integers.
  EXPECT_TRUE(refuses(good, {.isovalue = 0.5, .values = ShellValues::kExact}));
  for (const double isovalue : {kVoid, std::numeric_limits<double>::infinity(), 1e305}) {
    EXPECT_TRUE(refuses(good, {.isovalue = isovalue, .values = ShellValues::kLatticeExact}));
  }
  EXPECT_TRUE(refuses(good, {.isovalue = 16777216, .values = ShellValues::kExact}));
  for (const int resolution : {0, 9}) {
    EXPECT_TRUE(refuses(
        good,
        {.isovalue = 0.5, .values = ShellValues::kLatticeExact, .lattice_resolution = resolution}));
  }
  EXPECT_TRUE(refuses(good, {.isovalue = 0.5,
                             .values = ShellValues::kLatticeExact,
                             .lattice_resolution = 6,
                             .spacing_exponent = 3}));
  for (const int levels : {0, 3, 16}) {
    EXPECT_TRUE(refuses(
        good, {.isovalue = 0.5, .values = ShellValues::kQuantized, .levels_per_octave = levels}));
  }
  OwnedBox bad = good;
  bad.origin[1] = -1;
  EXPECT_TRUE(refuses(bad, options));
  bad.origin[1] = (1 << 15) - 7;  // Its last sample is outside the lattice.
  EXPECT_TRUE(refuses(bad, options));
  bad = good;
  bad.data_samples[2] = 66;
  EXPECT_TRUE(refuses(bad, options));
  bad = good;
  bad.data_samples[0] = 1;
  EXPECT_TRUE(refuses(bad, options));
  bad = good;
  bad.layers = 1;
  bad.layer_value = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(refuses(bad, options));
  bad = good;
  std::get<std::vector<float>>(bad.samples)[40] = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(refuses(bad, options));
}

}  // namespace
}  // namespace multitetra
