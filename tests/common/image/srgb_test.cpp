#include "common/image/srgb.hpp"

#include <gtest/gtest.h>

namespace multitetra {
namespace {

TEST(Srgb, ParsesColorsOfSixHexadecimalDigits) {
  EXPECT_EQ(rgb_from("fF8000"), (Rgb{255, 128, 0}));
  for (const char* const text : {"", "ff800", "ff80000", "-f8000", "0xff80", "ff80g0", " ff800"}) {
    EXPECT_EQ(rgb_from(text), std::nullopt) << text;
  }
}

TEST(Srgb, PacksAndUnpacksInTheOrderRedGreenBlue) {
  EXPECT_EQ(unpacked(0xdd8265), (Rgb{0xdd, 0x82, 0x65}));
  EXPECT_EQ(packed(Rgb{0xdd, 0x82, 0x65}), 0xdd8265U);
}

TEST(Srgb, ConvertsEveryValueToLightAndBack) {
  for (int value = 0; value < 256; ++value) {
    EXPECT_EQ(srgb_from(double{linear_light(value)}), value);
  }
  EXPECT_NEAR(double{linear_light(188)}, 0.5, 0.005);
  EXPECT_EQ(srgb_from(-1), 0);
  EXPECT_EQ(srgb_from(2), 255);
}

}  // namespace
}  // namespace multitetra
