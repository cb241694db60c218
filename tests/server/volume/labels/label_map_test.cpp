// Label fields are smooth, have every sample on its side, complement each other, and give the same
// boundary from both sides.
#include "server/volume/labels/label_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <random>
#include <stop_token>
#include <string>
#include <vector>

#include "common/base/in_parallel.hpp"
#include "common/base/vec3.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/volume/labels/label_borders.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/make_dataset.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra {
namespace {

namespace fields = testing::fields;

using Dims = std::array<std::int32_t, 3>;

template <typename Sample>
Volume labels_of(const Dims& dims, const std::function<int(int, int, int)>& label) {
  return fields::sampled<Sample>(
      dims, [&](int x, int y, int z) { return static_cast<Sample>(label(x, y, z)); });
}

// A ball of label 1 surrounded by label 2.
int ball_in_a_box(int x, int y, int z) {
  const double r = std::hypot(x - 15.3, y - 16.1, z - 14.6);
  return r < 9 ? 1 : 2;
}

LabelMap map_of(const Volume& volume, const TemporaryFolder& folder) {
  return {"seg.nrrd", *source_of(volume), folder.path()};
}

// A map whose fields do not know of its ends.
LabelMap open_map_of(const Volume& volume, const TemporaryFolder& folder) {
  return {"seg.nrrd", *source_of(volume), folder.path(), LabelEnds::kOpen};
}

std::vector<float> field_of(const LabelMap& map, double label) {
  return std::get<std::vector<float>>(map.field(label)->take_all());
}

DatasetPtr dataset_of(const LabelMap& map, double label, LabelEnds ends = LabelEnds::kOpen) {
  const bool is_closed = ends == LabelEnds::kClosed;
  return make_dataset(*map.field(label),
                      {.name = "label",
                       .outside = is_closed ? std::optional(kBeyondEnds) : std::nullopt,
                       .margin = is_closed ? 1 : 0,
                       .suggested_isovalues = {kLabelBoundary},
                       .bin_edges = {kLabelBinEdges.begin(), kLabelBinEdges.end()}});
}

TiledMesh surface_of(const LabelMap& map, double label, double error = 0) {
  return SurfaceExtractor(dataset_of(map, label))
      .extract({.request = {.isovalue = kLabelBoundary, .error = error, .simplify = error > 0}});
}

// The enclosed volume in units of a sample's. Requires a closed surface.
double volume_in(const TiledMesh& surface) {
  double sum = 0;
  for (const TileMesh& tile : surface.tiles) {
    for (const TriangleIndices& t : tile.mesh.triangles) {
      std::array<std::array<double, 3>, 3> v{};
      for (std::size_t i = 0; i < 3; ++i) {
        const LatticePoint& p = tile.mesh.vertices[t[i]];
        v[i] = {p.x / 32.0, p.y / 32.0, p.z / 32.0};
      }
      sum += v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) +
             v[0][1] * (v[1][2] * v[2][0] - v[1][0] * v[2][2]) +
             v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]);
    }
  }
  return sum / 6;
}

double label_at(const Volume& volume, std::size_t i) {
  return std::visit([&](const auto& samples) { return static_cast<double>(samples[i]); },
                    volume.samples);
}

// Independent random labels, the hardest to smooth.
Volume noise(const Dims& dims, unsigned labels, unsigned seed) {
  std::mt19937 random(seed);
  return labels_of<std::uint8_t>(
      dims, [&](int, int, int) { return static_cast<int>(random() % labels); });
}

// Triggers a stop when its samples have been read.
class StoppingSource : public VolumeSource {
 public:
  StoppingSource(const Volume& volume, std::stop_source& stop)
      : source_(source_of(volume)), stop_(stop) {}
  [[nodiscard]] const VolumeHeader& header() const override { return source_->header(); }
  void read(std::int32_t first_slice, std::int32_t slices, Samples& into) override {
    source_->read(first_slice, slices, into);
    stop_.request_stop();
  }

 private:
  std::unique_ptr<VolumeSource> source_;
  std::stop_source& stop_;
};

TEST(LabelMap, StopsOnRequestWhileItFindsBorders) {
  const TemporaryFolder folder;
  std::stop_source stop;
  StoppingSource source(labels_of<std::uint8_t>({32, 32, 32}, ball_in_a_box), stop);
  EXPECT_THROW(LabelMap("seg.nrrd", source, folder.path(), LabelEnds::kClosed, stop.get_token()),
               Cancelled);
}

TEST(LabelMap, FindsTheLabelsAndTheirExtents) {
  const TemporaryFolder folder;
  const Volume volume = labels_of<std::int16_t>({4, 3, 5}, [](int x, int y, int z) {
    if (x == 1 && y == 2 && z >= 1 && z <= 3) return -7;
    return z == 4 ? 300 : 0;
  });
  const LabelMap map = open_map_of(volume, folder);
  ASSERT_EQ(map.labels().size(), 2);
  EXPECT_EQ(map.labels()[0].value, -7);
  EXPECT_EQ(map.labels()[0].samples, 3);
  EXPECT_EQ(map.labels()[0].least, (std::array{1, 2, 1}));
  EXPECT_EQ(map.labels()[0].greatest, (std::array{1, 2, 3}));
  EXPECT_EQ(map.labels()[0].centroid, (Vec3{1, 2, 2}));
  EXPECT_EQ(map.labels()[1].value, 300);
  EXPECT_EQ(map.labels()[1].samples, 12);
  EXPECT_EQ(map.labels()[1].least, (std::array{0, 0, 4}));
  EXPECT_EQ(map.labels()[1].greatest, (std::array{3, 2, 4}));
  EXPECT_EQ(map.labels()[1].centroid, (Vec3{1.5, 1, 4}));
}

TEST(LabelMap, KeepsEverySampleOnItsSideInStepsOf256) {
  const TemporaryFolder folder;
  for (const Volume& volume : {noise({19, 7, 11}, 4, 1), noise({1, 1, 9}, 2, 2),
                               labels_of<float>({33, 30, 31}, ball_in_a_box)}) {
    const LabelMap map = open_map_of(volume, folder);
    for (const double label : {0.0, 1.0, 2.0, 3.0}) {
      const std::vector<float> field = field_of(map, label);
      for (std::size_t i = 0; i < field.size(); ++i) {
        const bool is_inside = label_at(volume, i) == label;
        ASSERT_EQ(field[i] * 256, std::trunc(field[i] * 256));
        ASSERT_GE(field[i], is_inside ? 132.0F / 256 : 0.0F);
        ASSERT_LE(field[i], is_inside ? 1.0F : 124.0F / 256);
      }
    }
  }
}

TEST(LabelMap, MakesFieldsOfTwoLabelsThatSumToOne) {
  const TemporaryFolder folder;
  for (const Volume& volume :
       {noise({23, 18, 9}, 2, 3), labels_of<std::uint16_t>({31, 31, 31}, [](int x, int y, int z) {
          return ball_in_a_box(x, y, z) - 1;
        })}) {
    const LabelMap map = open_map_of(volume, folder);
    const std::vector<float> zero = field_of(map, 0);
    const std::vector<float> one = field_of(map, 1);
    for (std::size_t i = 0; i < zero.size(); ++i) ASSERT_EQ(zero[i] + one[i], 1.0F);
  }
}

TEST(LabelMap, SmoothsOnlyNearTheLabel) {
  // Far from the boundary the field is constant; along a wall it depends only on the wall.
  const TemporaryFolder folder;
  const LabelMap map = open_map_of(
      labels_of<std::uint8_t>({12, 5, 6}, [](int x, int, int) { return x < 6 ? 5 : 0; }), folder);
  const std::vector<float> field = field_of(map, 5);
  const std::vector<float> expected = {
      1, 1, 1, 1, 240.0F / 256, 228.0F / 256, 28.0F / 256, 16.0F / 256, 0, 0, 0, 0};
  for (std::size_t i = 0; i < field.size(); ++i) ASSERT_EQ(field[i], expected[i % 12]) << i;
}

TEST(LabelMap, ReturnsTheSameSlicesInAnyOrderAndSlabs) {
  const TemporaryFolder folder;
  const Volume volume = noise({9, 8, 17}, 3, 4);
  const LabelMap map = open_map_of(volume, folder);
  const std::vector<float> whole = field_of(map, 1);
  const auto field = map.field(1);
  std::mt19937 random(5);
  Samples slab;
  for (int i = 0; i < 60; ++i) {
    const auto first = static_cast<std::int32_t>(random() % 17);
    const auto count =
        1 + static_cast<std::int32_t>(random() % (17 - static_cast<unsigned>(first)));
    field->read(first, count, slab);
    const auto& values = std::get<std::vector<float>>(slab);
    ASSERT_TRUE(std::equal(values.begin(), values.end(), whole.begin() + first * 72));
    ASSERT_EQ(values.size(), static_cast<std::size_t>(count) * 72);
  }
}

TEST(LabelMap, HasNoLabelAtVoidSamples) {
  const TemporaryFolder folder;
  Volume volume = labels_of<float>({5, 4, 3}, [](int, int, int) { return 2; });
  std::get<std::vector<float>>(volume.samples)[7] = std::nanf("");
  const LabelMap map = open_map_of(volume, folder);
  ASSERT_EQ(map.labels().size(), 1);
  EXPECT_EQ(map.labels()[0].samples, 59);
  EXPECT_LT(field_of(map, 2)[7], 0.5F);
}

TEST(LabelMap, RejectsVolumesWithoutLabels) {
  const TemporaryFolder folder;
  const auto refusal = [&](Volume volume) -> std::string {
    try {
      (void)map_of(volume, folder);
      return "";
    } catch (const VolumeFileError& error) {
      return error.what();
    }
  };
  Volume fraction = labels_of<float>({5, 4, 3}, [](int, int, int) { return 2; });
  std::get<std::vector<float>>(fraction.samples)[5 + 3] = 0.5F;
  EXPECT_EQ(refusal(fraction),
            "Cannot read 'seg.nrrd': its sample at 3, 1, 0 is 0.5, which is not an integer. "
            "Labels are for segmentations; prepare it without label options.");
  std::get<std::vector<float>>(fraction.samples)[5 + 3] = 3e7F;
  testing::expect_contains(refusal(fraction), "a label of 2^24 or more");
  testing::expect_contains(refusal(fraction), "Renumber the labels from 1");
  // 2^24 + 1 becomes the same float.
  std::get<std::vector<float>>(fraction.samples)[5 + 3] = 16'777'216;
  testing::expect_contains(refusal(fraction), "a label of 2^24 or more");
  std::get<std::vector<float>>(fraction.samples)[5 + 3] = 16'777'215;
  EXPECT_EQ(refusal(fraction), "");
  int next = 0;
  testing::expect_contains(
      refusal(labels_of<float>({300, 300, 1}, [&](int, int, int) { return ++next; })),
      "more than 65536 different values");
}

// Returns the mean angle between the triangles' normals and those of a ball, in degrees.
double mean_angle_to_ball(const TiledMesh& surface, const Vec3& center) {
  double angles = 0;
  double area = 0;
  for (const TileMesh& tile : surface.tiles) {
    for (const auto& triangle : tile.mesh.triangles) {
      std::array<Vec3, 3> corners;
      Vec3 outward{};
      for (std::size_t i = 0; i < 3; ++i) {
        const LatticePoint& v = tile.mesh.vertices[triangle[i]];
        corners[i] = {v.x / 32.0, v.y / 32.0, v.z / 32.0};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          outward[axis] += (corners[i][axis] - center[axis]) / 3;
        }
      }
      const Vec3 normal =
          cross(difference(corners[1], corners[0]), difference(corners[2], corners[0]));
      const double cosine = std::abs(dot(normal, outward)) / (length(normal) * length(outward));
      angles += length(normal) * std::acos(std::min(1.0, cosine));
      area += length(normal);
    }
  }
  return angles / area * 180 / std::numbers::pi;
}

TEST(LabelMap, SmoothsWithinAVoxelAndReducesStaircases) {
  // Checks the position and the smoothness of a ball's boundary.
  const TemporaryFolder folder;
  const LabelMap map = open_map_of(labels_of<std::uint8_t>({33, 33, 33}, ball_in_a_box), folder);
  const DatasetPtr dataset = dataset_of(map, 1);
  EXPECT_EQ(dataset->info.suggested_isovalues, std::vector<double>{0.5});
  const TiledMesh surface =
      SurfaceExtractor(dataset).extract({.request = {.isovalue = 0.5, .error = 0}});
  double sum = 0;
  std::size_t count = 0;
  for (const TileMesh& tile : surface.tiles) {
    for (const LatticePoint& v : tile.mesh.vertices) {
      const double r = std::hypot(v.x / 32.0 - 15.3, v.y / 32.0 - 16.1, v.z / 32.0 - 14.6);
      EXPECT_LT(std::abs(r - 9), 0.55);
      sum += (r - 9) * (r - 9);
      ++count;
    }
  }
  ASSERT_GT(count, 1000);
  EXPECT_LT(std::sqrt(sum / static_cast<double>(count)), 0.15);  // The unsmoothed indicator has
                                                                 // 0.21.
  EXPECT_LT(mean_angle_to_ball(surface, {15.3, 16.1, 14.6}), 6);
}

TEST(LabelMap, RisesEvenlyBetweenTheEdgesOfTerraces) {
  // A slope of one slice in `width` samples, along each axis: the distance of its vertices from the
  // plane through the edges of its steps, in slices. Steps reach 0.5.
  const TemporaryFolder folder;
  for (const int width : {2, 5, 8, 12}) {
    for (const std::size_t across : {0U, 1U, 2U}) {
      const std::size_t along = (across + 1) % 3;
      Dims dims = {22, 22, 22};
      dims[along] = 23 * width;
      const auto volume = labels_of<std::uint8_t>(dims, [&](int x, int y, int z) {
        const std::array<int, 3> at = {x, y, z};
        return at[along] < (at[across] + 1) * width ? 1 : 0;
      });
      const TiledMesh surface = surface_of(open_map_of(volume, folder), 1);
      double farthest = 0;
      std::size_t count = 0;
      for (const TileMesh& tile : surface.tiles) {
        for (const LatticePoint& v : tile.mesh.vertices) {
          const std::array<double, 3> at = {v.x / 32.0, v.y / 32.0, v.z / 32.0};
          if (*std::min_element(at.begin(), at.end()) < 7 || at[across] > 14) continue;
          const double plane = (at[along] + 0.5) / width - 1;
          farthest = std::max(farthest, std::abs(at[across] - plane));
          ++count;
        }
      }
      EXPECT_GT(count, 100) << width;
      EXPECT_LT(farthest, 0.25) << width << " across axis " << across;
    }
  }
}

// The sorted triangles, regardless of orientation.
std::vector<LatticeTriangle> places_of(const TiledMesh& surface) {
  std::vector<LatticeTriangle> places;
  for (const TileMesh& tile : surface.tiles) {
    for (const TriangleIndices& t : tile.mesh.triangles) {
      LatticeTriangle triangle = {tile.mesh.vertices[t[0]], tile.mesh.vertices[t[1]],
                                  tile.mesh.vertices[t[2]]};
      std::sort(triangle.begin(), triangle.end());
      places.push_back(triangle);
    }
  }
  std::sort(places.begin(), places.end());
  return places;
}

std::vector<LatticePoint> corners_of(const std::vector<LatticeTriangle>& triangles) {
  std::vector<LatticePoint> corners;
  for (const LatticeTriangle& triangle : triangles) {
    corners.insert(corners.end(), triangle.begin(), triangle.end());
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  return corners;
}

TEST(LabelMap, HasOneSurfaceBetweenTwoLabelsAtEveryThreshold) {
  const TemporaryFolder folder;
  for (const Volume& volume :
       {labels_of<std::uint8_t>({33, 33, 33}, ball_in_a_box),
        labels_of<std::uint8_t>({40, 21, 35}, [](int x, int y, int z) {
          return 1 +
                 static_cast<int>(std::sin(x / 3.0) + std::cos(y / 4.0) + std::sin(z / 5.0) > 0.3);
        })}) {
    const LabelMap map = open_map_of(volume, folder);
    const auto extractor_of = [&](double label) {
      return SurfaceExtractor(dataset_of(map, label));
    };
    const SurfaceExtractor one = extractor_of(1);
    const SurfaceExtractor two = extractor_of(2);
    for (const double error : {0.0, 0.3, 1.0, 3.0}) {
      const StepRequest step = {.request = {.isovalue = kLabelBoundary, .error = error}};
      const auto inner = places_of(one.extract(step));
      const auto outer = places_of(two.extract(step));
      ASSERT_GT(inner.size(), 50);
      EXPECT_EQ(corners_of(inner), corners_of(outer)) << error;
      EXPECT_EQ(inner.size(), outer.size()) << error;
      EXPECT_EQ(inner, outer) << error;
    }
  }
}

// The volume of label 1, in the surface and as the map reports it, divided by that of its samples.
struct Kept {
  double in_surface = 0;
  double as_found = 0;
  double thin = 0;  // The share in parts one sample thick.
};

Kept kept_of(const std::function<bool(int, int, int)>& is_inside, double error = 0) {
  const TemporaryFolder folder;
  const LabelMap map = open_map_of(
      labels_of<std::uint8_t>({26, 27, 25},
                              [&](int x, int y, int z) { return is_inside(x, y, z) ? 1 : 0; }),
      folder);
  const LabelSummary& found = map.labels()[0];
  const auto samples = static_cast<double>(found.samples);
  return {volume_in(surface_of(map, 1, error)) / samples, found.surface_samples / samples,
          static_cast<double>(found.thin_samples) / samples};
}

TEST(LabelMap, KeepsTheVolumeOfBallsInAllParities) {
  // The framework has 26 edges at samples whose coordinates are all odd or all even, 10 at others.
  for (const double radius : {0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0}) {
    for (int parity = 0; parity < 8; ++parity) {
      const std::array<int, 3> center = {12 + (parity & 1), 12 + (parity >> 1 & 1),
                                         12 + (parity >> 2 & 1)};
      const Kept kept = kept_of([&](int x, int y, int z) {
        return std::hypot(x - center[0], y - center[1], z - center[2]) <= radius;
      });
      EXPECT_NEAR(kept.in_surface, 1, radius < 2.5 ? 0.05 : 0.025) << radius << " at " << parity;
      EXPECT_NEAR(kept.as_found, kept.in_surface, 0.001) << radius << " at " << parity;
    }
  }
}

TEST(LabelMap, KeepsTheVolumeOfBallsAtAnyPlace) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> within(-0.5, 0.5);
  double sum = 0;
  constexpr int kBalls = 24;
  for (int ball = 0; ball < kBalls; ++ball) {
    const double radius = 3.5 + 4 * within(random);
    const std::array<double, 3> center = {12 + within(random), 12 + within(random),
                                          12 + within(random)};
    const Kept kept = kept_of([&](int x, int y, int z) {
      return std::hypot(x - center[0], y - center[1], z - center[2]) <= radius;
    });
    EXPECT_NEAR(kept.in_surface, 1, 0.04) << ball << " of radius " << radius;
    EXPECT_NEAR(kept.as_found, kept.in_surface, 0.002) << ball;
    sum += kept.in_surface;
  }
  EXPECT_NEAR(sum / kBalls, 1, 0.015);
}

TEST(LabelMap, EnclosesItsLabelsAtTheEndsOfTheMap) {
  const TemporaryFolder folder;
  const auto is_in_ball = [](int x, int y, int z) { return std::hypot(x - 2, y - 2, z - 1) < 6.3; };
  for (const auto& is_inside : std::vector<std::function<bool(int, int, int)>>{
           [](int, int, int) { return true; }, [](int, int, int z) { return z == 0; },
           [](int x, int y, int) { return x < 2 && y > 12; },
           [](int x, int y, int z) {
             return std::max({x, y, z}) < 3;
           },
           is_in_ball}) {
    const LabelMap map =
        map_of(labels_of<std::uint8_t>({16, 15, 17},
                                       [&](int x, int y, int z) { return is_inside(x, y, z); }),
               folder);
    const LabelSummary& label = map.labels()[0];
    const auto samples = static_cast<double>(label.samples);
    const TiledMesh surface =
        SurfaceExtractor(dataset_of(map, 1, LabelEnds::kClosed))
            .extract({.request = {.isovalue = kLabelBoundary, .error = 0, .simplify = false}});
    const double in_surface = volume_in(surface) / samples;
    // A ball that is cut off has a sharp edge.
    EXPECT_NEAR(in_surface, 1, is_inside(7, 2, 2) && !is_inside(15, 14, 16) ? 0.05 : 0.02)
        << samples;
    EXPECT_NEAR(label.surface_samples / samples, in_surface, 0.001) << samples;
  }
}

TEST(LabelMap, MakesBordersFromTheirNeighborhood) {
  // Shapes of all kinds, and others beyond the reach: thick, thin and noisy ones.
  const TemporaryFolder folder;
  constexpr int kNear = 6;
  const auto field_near = [&](int side, const std::function<int(int, int, int)>& beyond) {
    std::mt19937 random(9);
    const LabelMap map =
        open_map_of(labels_of<std::uint8_t>({10, side, 11},
                                            [&](int x, int y, int z) -> int {
                                              if (y >= kNear + kLabelReach) {
                                                return beyond(x, y, z);
                                              }
                                              if (y > 40) return x < 5 ? 1 : 0;
                                              if (y > 9) return x + y + z < 30;
                                              return static_cast<int>(random() % 2);
                                            }),
                    folder);
    std::vector<float> near;
    const std::vector<float> field = field_of(map, 1);
    for (std::size_t i = 0; i < field.size(); ++i) {
      if (static_cast<int>(i / 10) % side < kNear) near.push_back(field[i]);
    }
    return near;
  };
  const auto nothing = field_near(90, [](int, int, int) { return 0; });
  EXPECT_EQ(field_near(kNear + kLabelReach, [](int, int, int) { return 0; }), nothing);
  EXPECT_EQ(field_near(90, [](int, int, int) { return 1; }), nothing);
  EXPECT_EQ(field_near(90, [](int x, int y, int z) { return (x ^ y ^ z) & 1; }), nothing);
}

// A tube of `width` samples a side along an axis or a diagonal of several axes.
std::function<bool(int, int, int)> tube(int width, std::array<int, 3> along, int first) {
  return [=](int x, int y, int z) {
    const std::array<int, 3> at = {x, y, z};
    for (int start = 4; start < 18; ++start) {
      bool is_inside = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const int low = along[axis] != 0 ? start : first;
        is_inside = is_inside && at[axis] >= low && at[axis] < low + width;
      }
      if (is_inside) return true;
    }
    return false;
  };
}

TEST(LabelMap, KeepsTheVolumeOfTubes) {
  for (const int width : {1, 2, 3}) {
    for (const std::array<int, 3>& along :
         {std::array{1, 0, 0}, std::array{0, 0, 1}, std::array{1, 1, 0}, std::array{1, 1, 1}}) {
      for (const int first : {9, 10}) {
        const Kept kept = kept_of(tube(width, along, first));
        const double allowed = width == 1 ? 0.1 : 0.05;
        EXPECT_NEAR(kept.in_surface, 1, allowed)
            << width << " along " << along[0] << along[1] << along[2] << " from " << first;
        EXPECT_NEAR(kept.as_found, kept.in_surface, 0.03);  // Vertices are rounded to the lattice.
      }
    }
  }
}

TEST(LabelMap, KeepsTheVolumeOfSheetsAndBalls) {
  for (const int width : {1, 2, 3}) {
    const Kept kept = kept_of([&](int x, int y, int z) {
      return std::min({x, y}) >= 4 && std::max({x, y}) < 20 && z >= 9 && z < 9 + width;
    });
    EXPECT_NEAR(kept.in_surface, 1, 0.03) << width;
  }
  const Kept oblique = kept_of([](int x, int y, int z) {
    return x + y == 22 && std::min({x, y, z}) >= 4 && z < 20;
  });
  EXPECT_NEAR(oblique.in_surface, 1, 0.05);
  const Kept diagonal = kept_of([](int x, int y, int z) {
    return x + y + z == 33 && std::min({x, y, z}) >= 4 && std::max({x, y, z}) < 20;
  });
  EXPECT_NEAR(diagonal.in_surface, 1, 0.05);
  for (const int radius : {2, 3, 4, 5, 6, 7, 8}) {
    const Kept kept = kept_of(
        [&](int x, int y, int z) { return std::hypot(x - 12.3, y - 12.6, z - 12.1) < radius; });
    EXPECT_NEAR(kept.in_surface, 1, radius == 2 ? 0.05 : 0.025) << radius;
    EXPECT_NEAR(kept.as_found, kept.in_surface, 0.02) << radius;
  }
}

std::function<bool(int, int, int)> sheet(int width) {
  return [=](int x, int y, int z) {
    return std::min({x, y}) >= 4 && std::max({x, y}) < 20 && z >= 9 && z < 9 + width;
  };
}

// Checks what labels/README.md states about the default error.
TEST(LabelMap, KeepsMostOfTheVolumeOfThinPartsInSimplifiedSurfaces) {
  for (const int width : {1, 2, 3}) {
    for (const auto& [error, loss] : {std::pair{0.125, 0.1}, {0.25, 0.1}}) {
      EXPECT_NEAR(kept_of(sheet(width), error).in_surface, 1, loss)
          << "sheet of " << width << " at " << error;
      EXPECT_NEAR(kept_of(tube(width, {1, 0, 0}, 9), error).in_surface, 1, 0.05)
          << "tube of " << width << " at " << error;
    }
  }
}

TEST(LabelMap, CountsTheSamplesOfPartsOneSampleThick) {
  EXPECT_EQ(kept_of(sheet(1)).thin, 1);
  EXPECT_EQ(kept_of(tube(1, {1, 1, 1}, 9)).thin, 1);
  EXPECT_EQ(kept_of(sheet(2)).thin, 0);
  EXPECT_EQ(kept_of(tube(2, {0, 0, 1}, 9)).thin, 0);
  // A block of 4 x 4 x 4 with a thread of 8 samples.
  const Kept both = kept_of([](int x, int y, int z) {
    const bool is_block = std::min({x, y, z}) >= 6 && std::max({x, y, z}) < 10;
    return is_block || (y == 8 && z == 8 && x >= 10 && x < 18);
  });
  EXPECT_EQ(both.thin, 8.0 / (64 + 8));
}

TEST(LabelMap, KeepsTheVolumesOfThinLabelsThatTouch) {
  const TemporaryFolder folder;
  const LabelMap map =
      map_of(labels_of<std::uint8_t>({24, 24, 24},
                                     [](int x, int y, int z) {
                                       if (std::min(x, y) < 4 || std::max(x, y) >= 20) return 0;
                                       if (z == 8) return 1;
                                       if (z == 9 || z == 10) return 2;
                                       return z > 10 && z < 18 ? 3 : 0;
                                     }),
             folder);
  for (const LabelSummary& found : map.labels()) {
    const auto samples = static_cast<double>(found.samples);
    EXPECT_NEAR(volume_in(surface_of(map, found.value)) / samples, 1, 0.05) << found.value;
    EXPECT_NEAR(found.surface_samples / samples, 1, 0.05) << found.value;
  }
}

TEST(LabelMap, KeepsMostOfLabelsThatChangeFromSampleToSample) {
  const TemporaryFolder folder;
  const LabelMap map =
      map_of(labels_of<std::uint8_t>({16, 16, 16},
                                     [](int x, int y, int z) { return 1 + (x + y + z) % 3; }),
             folder);
  for (const LabelSummary& found : map.labels()) {
    EXPECT_NEAR(found.surface_samples / static_cast<double>(found.samples), 1, 0.16);
  }
}

TEST(LabelMap, SharesTrianglesOfTwoLabelsBesideAThird) {
  // Adjacent blocks of 5 x 5 x 5 in the background.
  const TemporaryFolder folder;
  const LabelMap map =
      open_map_of(labels_of<std::uint8_t>({20, 15, 15},
                                          [](int x, int y, int z) {
                                            if (std::min(y, z) < 5 || std::max(y, z) >= 10)
                                              return 0;
                                            return x < 5 ? 0 : x < 10 ? 1 : x < 15 ? 2 : 0;
                                          }),
                  folder);
  const auto one = places_of(surface_of(map, 1));
  const auto two = places_of(surface_of(map, 2));
  std::vector<LatticeTriangle> shared;
  std::set_intersection(one.begin(), one.end(), two.begin(), two.end(), std::back_inserter(shared));
  // The common face has 4 x 4 cells with only these two labels, of two triangles or more.
  EXPECT_GE(shared.size(), 32);
  const auto vertices_at_border = [](const std::vector<LatticeTriangle>& triangles) {
    std::vector<LatticePoint> corners;
    for (const LatticePoint& p : corners_of(triangles)) {
      // Between samples 9 and 10 along x, and inside both blocks.
      if (p.x > 9 * 32 && p.x < 10 * 32 && std::min(p.y, p.z) >= 5 * 32 &&
          std::max(p.y, p.z) <= 9 * 32) {
        corners.push_back(p);
      }
    }
    return corners;
  };
  EXPECT_EQ(vertices_at_border(one), vertices_at_border(two));
  EXPECT_GE(vertices_at_border(one).size(), 25);
}

}  // namespace
}  // namespace multitetra
