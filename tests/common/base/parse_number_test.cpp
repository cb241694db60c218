#include "common/base/parse_number.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

TEST(ParseNumber, RequiresTheWholeText) {
  EXPECT_EQ(parse_number<double>("-3.5e2"), -350);
  EXPECT_EQ(parse_number<std::uint16_t>("65535"), 65535);
  EXPECT_EQ(parse_number<std::uint32_t>("ff8000", 16), 0xff8000U);
  for (const char* wrong : {"", " 1", "1 ", "1x", "+1", "65536"}) {
    EXPECT_EQ(parse_number<std::uint16_t>(wrong), std::nullopt) << wrong;
  }
}

TEST(ParseNumbers, RequiresTheGivenCount) {
  EXPECT_EQ(parse_numbers<double>("1.5,-2", 2), (std::vector<double>{1.5, -2}));
  EXPECT_EQ(parse_numbers<int>("640x480", 2, 'x'), (std::vector<int>{640, 480}));
  for (const char* wrong : {"", "1", "1,", ",1", "1,2,3", "1,,2", "1,2,"}) {
    EXPECT_EQ(parse_numbers<double>(wrong, 2), std::nullopt) << wrong;
  }
}

TEST(ParseFinite, RejectsInfinityAndNan) {
  EXPECT_EQ(parse_finite("-2.5"), -2.5);
  for (const char* wrong : {"inf", "-inf", "nan", "1e999", "", "1 "}) {
    EXPECT_EQ(parse_finite(wrong), std::nullopt) << wrong;
  }
}

TEST(TakeNumber, RemovesOnlyTheNumber) {
  std::string_view text = "12-34_x";
  EXPECT_EQ(take_number<int>(text), 12);
  EXPECT_EQ(take_number<int>(text), -34);
  EXPECT_EQ(take_number<int>(text), std::nullopt);
  EXPECT_EQ(text, "_x");
}

}  // namespace
}  // namespace multitetra
