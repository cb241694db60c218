#include "common/image/color_map.hpp"

#include "common/image/label_color.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <string>

namespace multitetra {
namespace {

using ColorMapTest = ::testing::Test;

std::string hex(const Rgb& color) {
  std::string text;
  for (const std::uint8_t part : color) {
    text += "0123456789abcdef"[part >> 4];
    text += "0123456789abcdef"[part & 15];
  }
  return text;
}

// The viewer's colors are checked against the same file.
TEST_F(ColorMapTest, MatchesTheGoldenColors) {
  std::ifstream file(MULTITETRA_TEST_DATA "/colors.txt");
  std::set<std::string> maps;
  std::size_t count = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    std::string map;
    std::string kind;
    std::string color;
    ColorScale scale;
    double value = 0;
    ASSERT_TRUE(words >> map >> kind >> scale.low >> scale.high >> value >> color) << line;
    const auto known = color_map_from(map);
    const auto is_logarithmic = is_logarithmic_from(kind == "lin" ? "linear" : kind);
    ASSERT_TRUE(known && is_logarithmic) << line;
    scale.map = *known;
    scale.is_logarithmic = *is_logarithmic;
    EXPECT_EQ(hex(scale(value)), color) << line;
    maps.insert(map);
    ++count;
  }
  EXPECT_GT(count, 400U);
  EXPECT_EQ(maps.size(), 4U);
}

// The viewer's test has the same.
TEST_F(ColorMapTest, ColorsLabelsAsTheViewer) {
  EXPECT_EQ(hex(label_color(1)), "5cceb7");
  EXPECT_EQ(hex(label_color(2)), "ac7dc0");
  EXPECT_EQ(hex(label_color(3)), "d0b660");
  EXPECT_EQ(hex(label_color(64)), "10a6ad");
  EXPECT_EQ(hex(label_color(1000)), "cd776c");
}

TEST_F(ColorMapTest, ColorsNanSeparately) {
  const ColorScale scale{.map = ColorMap::kViridis, .no_value = {1, 2, 3}};
  EXPECT_EQ(scale(std::numeric_limits<double>::quiet_NaN()), (Rgb{1, 2, 3}));
  EXPECT_EQ(scale(std::numeric_limits<double>::infinity()), scale(1));
}

}  // namespace
}  // namespace multitetra
