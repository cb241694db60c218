#include "server/extraction/packed_values.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace multitetra::testing {
namespace {

// Unpacks by the description in the protocol.
template <typename Bits>
std::vector<Bits> unpacked(const PackedValues& packed, std::size_t count) {
  std::vector<Bytef> planes(count * sizeof(Bits) + 1);
  uLongf length = planes.size();
  EXPECT_EQ(uncompress(planes.data(), &length, reinterpret_cast<const Bytef*>(packed.bytes.data()),
                       packed.bytes.size()),
            Z_OK);
  EXPECT_EQ(length, count * sizeof(Bits));
  std::vector<Bits> values(count);
  Bits before = 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::uint64_t code = 0;
    for (std::size_t byte = 0; byte < sizeof(Bits); ++byte) {
      code |= std::uint64_t{planes[byte * count + i]} << (8 * byte);
    }
    const std::uint64_t range = std::uint64_t{1} << (8 * sizeof(Bits));
    const std::uint64_t difference = code % 2 == 0 ? code / 2 : (2 * range - 1 - code) / 2;
    before = values[i] = static_cast<Bits>(before + difference);
  }
  return values;
}

TEST(PackedValues, AreNumbersOfTheTypeThatHoldsThem) {
  const std::vector<float> values = {0, 32767, -32768, -1, 1, 0, 0, -1024, 3071};
  const PackedValues packed = packed_values(values, SampleType::kI16);
  EXPECT_EQ(packed.type, SampleType::kI16);
  const std::vector<std::uint16_t> found = unpacked<std::uint16_t>(packed, values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(static_cast<float>(std::bit_cast<std::int16_t>(found[i])), values[i]) << i;
  }
  const PackedValues bytes = packed_values(std::vector<float>{255, 0, 7}, SampleType::kU8);
  EXPECT_EQ(unpacked<std::uint8_t>(bytes, 3), (std::vector<std::uint8_t>{255, 0, 7}));
}

TEST(PackedValues, AreFloatsWhereTheTypeDoesNotHoldAll) {
  for (const float odd : {0.5F, 65536.0F, -1.0F, std::nanf("")}) {
    const std::vector<float> values = {1, odd, 3};
    const PackedValues packed = packed_values(values, SampleType::kU16);
    EXPECT_EQ(packed.type, SampleType::kF32);
    const std::vector<std::uint32_t> found = unpacked<std::uint32_t>(packed, values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      EXPECT_EQ(found[i], std::bit_cast<std::uint32_t>(values[i]));
    }
  }
}

TEST(PackedValues, OfAirAreFew) {
  EXPECT_LT(packed_values(std::vector<float>(1 << 20, -1024), SampleType::kI16).bytes.size(),
            std::size_t{1} << 14);
}

}  // namespace
}  // namespace multitetra::testing
