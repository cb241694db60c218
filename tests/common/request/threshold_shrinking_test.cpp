#include "common/request/threshold_shrinking.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace multitetra {
namespace {

const float kSilent = std::nanf("");

struct Image {
  std::array<std::int32_t, 3> dims;
  std::vector<float> values;
  Affine map = {};

  [[nodiscard]] ThresholdGrid shrunk_to(std::size_t limit, double elsewhere = 100) const {
    return shrunk({.dims = dims, .index_to_world = map, .thresholds = values}, elsewhere, limit);
  }
};

TEST(ThresholdShrinking, KeepsAGridThatFits) {
  const Image image{{2, 2, 1}, {1, 2, kSilent, 4}};
  EXPECT_EQ(
      image.shrunk_to(4),
      (ThresholdGrid{.dims = {2, 2, 1}, .index_to_world = {}, .thresholds = {1, 2, kSilent, 4}}));
}

TEST(ThresholdShrinking, UsesTheLeastOfEachBlockAtItsMiddle) {
  Image image{{4, 1, 1}, {5, 3, 9, 7}};
  image.map.columns[0] = {0, 2, 0};
  image.map.translation = {10, 20, 30};
  const ThresholdGrid grid = image.shrunk_to(2);
  EXPECT_EQ(grid.thresholds, (std::vector<float>{3, 7}));
  EXPECT_EQ(grid.index_to_world.columns[0], (Vec3{0, 4, 0}));
  EXPECT_EQ(grid.index_to_world.translation, (Vec3{10, 21, 30}));
}

TEST(ThresholdShrinking, JoinsMoreSamplesAlongDenserAxes) {
  Image image{{64, 64, 16}, std::vector<float>(64 * 64 * 16, 2.0F)};
  image.map.columns[2] = {0, 0, 4};
  EXPECT_EQ(image.shrunk_to(16 * 16 * 16).dims, (std::array{16, 16, 16}));
}

TEST(ThresholdShrinking, NeverRaisesAThreshold) {
  const Image image{{6, 1, 1}, {5, kSilent, kSilent, kSilent, 4, 4}};
  EXPECT_EQ(image.shrunk_to(3, 2).thresholds[0], 2)
      << "a part of the block has what holds elsewhere";
  EXPECT_EQ(image.shrunk_to(3, 8).thresholds[0], 5);
  EXPECT_TRUE(std::isnan(image.shrunk_to(3, 2).thresholds[1]));
  EXPECT_EQ(image.shrunk_to(3, 2).thresholds[2], 4);
  EXPECT_EQ(image.shrunk_to(2, 2).dims[0], 2);
  const Image odd{{5, 1, 1}, {9, 9, 9, 9, 9}};
  EXPECT_EQ(odd.shrunk_to(3, 2).thresholds, (std::vector<float>{9, 9, 2}))
      << "the last block reaches beyond the image";
}

TEST(ThresholdShrinking, FitsAnyImage) {
  std::mt19937_64 random(3);
  for (const std::array<std::int32_t, 3>& dims :
       {std::array{300, 200, 70}, {1000000, 1, 1}, {1, 513, 513}, {64, 64, 33}}) {
    Image image{dims, std::vector<float>(static_cast<std::size_t>(dims[0]) *
                                         static_cast<std::size_t>(dims[1]) *
                                         static_cast<std::size_t>(dims[2]))};
    for (float& value : image.values) value = static_cast<float>(random() % 1000);
    const ThresholdGrid grid = image.shrunk_to(kMaxGridThresholds, 500);
    EXPECT_LE(grid.thresholds.size(), kMaxGridThresholds);
    EXPECT_GT(grid.thresholds.size(), kMaxGridThresholds / 3);
    const LocalThresholds thresholds{.grid = std::make_shared<const ThresholdGrid>(grid)};
    EXPECT_TRUE(check_thresholds(thresholds));
  }
}

}  // namespace
}  // namespace multitetra
