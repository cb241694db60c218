// Encoded bits decode to the same bits.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "common/codec/detail/level_of_distance.hpp"
#include "common/codec/detail/level_scale.hpp"
#include "common/codec/detail/range_encoder.hpp"
#include "common/codec/detail/row_bits.hpp"

namespace multitetra::shell {
namespace {

RangeDecoder decoder_of(const RangeEncoder& encoder) {
  return {encoder.bytes().data(), encoder.bytes().size(), encoder.raw().data(),
          encoder.raw().size()};
}

TEST(RangeCoder, RoundTripsBitsOfEveryProbability) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const int count = static_cast<int>(random() % 300);
    const std::uint64_t likely = random() % 1001;
    std::vector<bool> bits;
    std::vector<std::uint32_t> raw;
    RangeEncoder encoder;
    Probability contexts[3];
    for (int i = 0; i < count; ++i) {
      bits.push_back(random() % 1000 < likely);
      encoder.bit(contexts[i % 3], bits.back());
      const int length = 1 + i % 24;
      raw.push_back(static_cast<std::uint32_t>(random()) & ((1U << length) - 1));
      encoder.raw_bits(length, raw.back());
    }
    encoder.finish();
    RangeDecoder decoder = decoder_of(encoder);
    Probability same[3];
    for (int i = 0; i < count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      ASSERT_EQ(decoder.bit(same[i % 3]), bits[at]);
      ASSERT_EQ(decoder.raw_bits(1 + i % 24), raw[at]);
    }
    EXPECT_TRUE(decoder.is_used_up());
    EXPECT_FALSE(decoder.is_overrun());
  }
}

// An improbable bit selects the top of the interval, so carries propagate through bytes of 255.
TEST(RangeCoder, PropagatesCarries) {
  for (int surprise = 1; surprise < 3000; surprise += 7) {
    RangeEncoder encoder;
    Probability context;
    for (int i = 0; i < 3000; ++i) encoder.bit(context, i % surprise != 0);
    encoder.finish();
    RangeDecoder decoder = decoder_of(encoder);
    Probability same;
    for (int i = 0; i < 3000; ++i) ASSERT_EQ(decoder.bit(same), i % surprise != 0);
    EXPECT_TRUE(decoder.is_used_up());
  }
}

TEST(RangeCoder, DetectsMissingAndExcessBytes) {
  RangeEncoder encoder;
  std::mt19937_64 random(2);
  std::vector<Probability> contexts(200);
  for (Probability& p : contexts) encoder.bit(p, random() % 2 != 0);
  encoder.finish();
  std::vector<std::uint8_t> bytes = encoder.bytes();
  const auto read = [&] {
    RangeDecoder decoder(bytes.data(), bytes.size(), nullptr, 0);
    std::vector<Probability> same(200);
    for (Probability& p : same) decoder.bit(p);
    return decoder;
  };
  EXPECT_TRUE(read().is_used_up());
  bytes.insert(bytes.end(), RangeDecoder::kMaxMissing + 1, 0);
  EXPECT_FALSE(read().is_used_up());
  bytes.resize(bytes.size() - 12);
  EXPECT_FALSE(read().is_used_up());
  EXPECT_TRUE(read().is_overrun());
}

TEST(LevelOfDistance, RoundsTheLogarithm) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 100000; ++i) {
    const double distance = std::exp2(static_cast<double>(random() % 2000) - 1060) *
                            (1 + static_cast<double>(random() >> 11) * 0x1.0p-53);
    for (const int levels : {1, 2, 4, 8}) {
      const double exact = std::log2(distance) * levels;
      EXPECT_LE(std::abs(level_of_distance(distance, levels) - exact), 0.5 + 1e-9) << distance;
    }
  }
  EXPECT_EQ(level_of_distance(1, 8), 0);
  EXPECT_EQ(level_of_distance(0x1p-1074, 2), -2148);
}

TEST(LevelScale, CutsAtTheQuantizedDistances) {
  const auto scale = std::make_unique<LevelScale>();
  for (const int levels : {1, 2, 4, 8}) {
    for (const int resolution : {1, 5, 8}) {
      for (const int exponent : {0, 5, 12}) {
        ShellHeader header;
        header.values = ShellValues::kQuantized;
        header.levels_per_octave = levels;
        header.lattice_resolution = resolution;
        header.spacing_exponent = exponent;
        header.levels = 400;
        scale->begin(header);
        const double steps = header.steps();
        for (int a = 1; a < 400; a += 3) {
          for (int b = 1; b < 400; b += 7) {
            const double t = 1 / (1 + std::exp2(static_cast<double>(b - a) / levels));
            const double nearest = std::clamp(std::floor(t * steps + 0.5), 1.0, steps - 1);
            ASSERT_EQ(scale->cut(a, b), nearest) << a << " " << b;
          }
        }
        EXPECT_EQ(scale->cut(0, 5), 1);
        EXPECT_EQ(scale->cut(5, 0), header.steps() - 1);
      }
    }
  }
}

TEST(BitField, KeepsSamplePositionsInALargerBox) {
  std::mt19937_64 random(4);
  const auto field = std::make_unique<BitField>();
  for (int trial = 0; trial < 50; ++trial) {
    const int data[3] = {1 + static_cast<int>(random() % 63), 1 + static_cast<int>(random() % 9),
                         1 + static_cast<int>(random() % 9)};
    std::vector<bool> bits;
    field->begin(data[0], data[1], data[2]);
    for (int z = 0; z < data[2]; ++z) {
      for (int y = 0; y < data[1]; ++y) {
        for (int x = 0; x < data[0]; ++x) {
          bits.push_back(random() % 2 != 0);
          if (bits.back()) field->row(y, z) |= samples_from_to(x, x + 1);
        }
      }
    }
    field->finish();
    const bool around = random() % 2 != 0;
    int low[3];
    int size[3];
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = static_cast<int>(random() % 2);
      size[axis] = data[axis] + low[axis] + static_cast<int>(random() % 2);
    }
    field->enclose(low, size, around);
    field->finish();
    for (int z = -1; z <= size[2]; ++z) {
      for (int y = -1; y <= size[1]; ++y) {
        for (int x = -1; x <= size[0]; ++x) {
          const int at[3] = {x, y, z};
          int i[3];
          bool is_data = true;
          for (int axis = 0; axis < 3; ++axis) {
            i[axis] = std::clamp(at[axis], 0, size[axis] - 1) - low[axis];
            is_data = is_data && i[axis] >= 0 && i[axis] < data[axis];
          }
          const bool expected =
              is_data ? bits[static_cast<std::size_t>(i[0] + data[0] * (i[1] + data[1] * i[2]))]
                      : around;
          ASSERT_EQ(field->at(x, y, z), expected);
        }
      }
    }
  }
}

}  // namespace
}  // namespace multitetra::shell
