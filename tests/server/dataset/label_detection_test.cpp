// Label maps are distinguished from images by regions of equal values.
#include "server/dataset/label_detection.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "server/dataset/prepare.hpp"
#include "server/dataset/prepared_file.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra {
namespace {

namespace fields = testing::fields;

constexpr int kSide = 48;

bool looks_so(Volume volume) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "volume.mtd";
  prepare(*source_of(std::move(volume)), {.name = "volume"}, file, {});
  const PreparedFile prepared(file.string());
  return looks_like_labels(prepared.info(), *prepared.samples());
}

template <typename Sample>
bool looks_so(const std::function<double(int, int, int)>& value) {
  return looks_so(fields::sampled<Sample>({kSide, kSide, kSide}, value));
}

// The number of the nearest of 60 centers where it is closer than `radius`, else 0.
double cell(int x, int y, int z, double radius) {
  static const std::vector<std::array<double, 3>> centers = [] {
    std::mt19937_64 random(5);
    std::vector<std::array<double, 3>> all(60);
    for (auto& center : all)
      for (double& part : center) part = kSide * fields::uniform(random);
    return all;
  }();
  double nearest = radius;
  double number = 0;
  for (std::size_t i = 0; i < centers.size(); ++i) {
    const double distance = std::hypot(x - centers[i][0], y - centers[i][1], z - centers[i][2]);
    if (distance >= nearest) continue;
    nearest = distance;
    number = static_cast<double>(i + 1);
  }
  return number;
}

TEST(LabelDetection, RecognizesManyOrFewLabelsOfEachType) {
  for (const double radius : {3.0, 99.0}) {
    const auto cells = [&](int x, int y, int z) { return cell(x, y, z, radius); };
    EXPECT_TRUE(looks_so<std::uint16_t>(cells)) << radius;
    EXPECT_TRUE(looks_so<float>(cells)) << radius;
    EXPECT_TRUE(looks_so<std::uint8_t>([&](int x, int y, int z) { return cells(x, y, z) > 30; }));
    // Labels of a brain atlas.
    EXPECT_TRUE(looks_so<std::int16_t>([&](int x, int y, int z) { return 35 * cells(x, y, z); }));
  }
}

TEST(LabelDetection, TakesImagesForImages) {
  const auto distance = [](int x, int y, int z) {
    return std::hypot(x - 23.3, y - 22.1, z - 24.6);
  };
  EXPECT_FALSE(looks_so<std::uint8_t>([&](int x, int y, int z) { return 6 * distance(x, y, z); }));
  EXPECT_FALSE(looks_so<float>(distance));
  EXPECT_FALSE(looks_so<std::uint8_t>([&](int x, int y, int z) {
    return std::floor(0.5 * distance(x, y, z));
  })) << "a smooth field has regions";
  EXPECT_FALSE(looks_so<std::int16_t>([](int, int, int) { return 7; })) << "one value";
  EXPECT_FALSE(looks_so(fields::integer_noise({kSide, kSide, kSide}, 20, 3))) << "few values";
  // A scan with air, saturated bone, and one tissue of equal samples.
  std::mt19937_64 random(9);
  EXPECT_FALSE(looks_so<std::uint8_t>([&](int x, int y, int z) {
    const double r = distance(x, y, z);
    if (r > 22) return 0.0;
    if (r < 4) return 255.0;
    return r < 15 ? 80.0 : std::floor(100 + 100 * fields::uniform(random));
  }));
}

TEST(LabelDetection, SkipsSamplesWithoutValue) {
  const auto cells = [](int x, int y, int z) {
    return x % 5 == 0 ? std::numeric_limits<double>::quiet_NaN() : cell(x, y, z, 99);
  };
  EXPECT_TRUE(looks_so<float>(cells));
}

}  // namespace
}  // namespace multitetra
