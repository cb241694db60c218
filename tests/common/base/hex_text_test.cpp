#include "common/base/hex_text.hpp"

#include <array>

#include <gtest/gtest.h>

namespace multitetra {
namespace {

TEST(HexText, WritesTwoDigitsPerByteAndSixteenPerNumber) {
  const std::array bytes = {std::byte{0x00}, std::byte{0x9f}, std::byte{0xa0}};
  EXPECT_EQ(hex_text(bytes), "009fa0");
  EXPECT_EQ(hex_text(std::uint64_t{0x0123456789abcdef}), "0123456789abcdef");
}

TEST(BytesFromHex, AcceptsOnlyPairsOfDigitsInEitherCase) {
  EXPECT_EQ(bytes_from_hex("009Fa0"),
            (std::vector{std::byte{0x00}, std::byte{0x9f}, std::byte{0xa0}}));
  EXPECT_EQ(bytes_from_hex(""), std::vector<std::byte>());
  for (const char* wrong : {"0", "0g", "0x00", " 00", "0-"}) {
    EXPECT_EQ(bytes_from_hex(wrong), std::nullopt) << wrong;
  }
}

}  // namespace
}  // namespace multitetra
