#include "server/dataset/brick_codec.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <vector>

#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/dataset/brick_order.hpp"
#include "server/dataset/detail/packed_bytes.hpp"

namespace multitetra {
namespace {

using Bytes = std::vector<std::byte>;

// Smooth, noisy and constant bricks, with whole and partial sizes.
std::vector<Bytes> bricks_of(std::size_t item_bytes) {
  std::mt19937 random(3);
  std::vector<Bytes> bricks;
  for (const std::size_t items : {0U, 1U, 2U, 7U, 100U, 4096U, 100'000U}) {
    for (const int kind : {0, 1, 2}) {
      Bytes brick(items * item_bytes);
      for (std::size_t i = 0; i < brick.size(); ++i) {
        const std::size_t item = i / item_bytes;
        const bool is_low = i % item_bytes == 0;
        if (kind == 0) brick[i] = static_cast<std::byte>(random());
        if (kind == 1) brick[i] = static_cast<std::byte>(is_low ? item / 50 : 3);
        if (kind == 2) brick[i] = static_cast<std::byte>(i % item_bytes + 5);
      }
      bricks.push_back(brick);
    }
  }
  return bricks;
}

TEST(BrickCodec, RoundTripsEveryBrick) {
  for (const std::size_t item_bytes : {1U, 2U, 4U}) {
    for (const Bytes& brick : bricks_of(item_bytes)) {
      const PackedBrick packed = pack_brick(brick, item_bytes);
      EXPECT_LE(packed.bytes.size(), brick.size());
      Bytes back(brick.size());
      ASSERT_TRUE(unpack_brick(packed.codec, packed.bytes, back)) << brick.size();
      EXPECT_TRUE(back == brick);
      const PackedBrick sized = pack_sized(brick);
      EXPECT_EQ(unpacked_size(sized.codec, sized.bytes), brick.size());
      Bytes again(brick.size());
      ASSERT_TRUE(unpack_brick(sized.codec, sized.bytes, again));
      EXPECT_TRUE(again == brick);
    }
  }
}

TEST(BrickCodec, CompressesSmoothBricksAndStoresNoiseRaw) {
  const std::vector<Bytes> bricks = bricks_of(2);
  const std::size_t last = bricks.size() - 3;
  EXPECT_EQ(pack_brick(bricks[last], 2).codec, BrickCodec::kRaw);
  EXPECT_EQ(pack_brick(bricks[last + 1], 2).codec, BrickCodec::kBlosc);
  EXPECT_LT(pack_brick(bricks[last + 1], 2).bytes.size(), bricks[last + 1].size() / 4);
  EXPECT_EQ(pack_brick(bricks[last + 2], 2).codec, BrickCodec::kConstant);
  EXPECT_EQ(pack_brick(bricks[last + 2], 2).bytes.size(), 2U);
}

TEST(BrickCodec, RejectsWrongSizesAndArbitraryBytes) {
  std::mt19937 random(9);
  const Bytes brick = bricks_of(2)[16];
  const PackedBrick packed = pack_brick(brick, 2);
  ASSERT_EQ(packed.codec, BrickCodec::kBlosc);
  for (const std::size_t size : {std::size_t{0}, brick.size() - 1, brick.size() + 1}) {
    Bytes into(size);
    EXPECT_FALSE(unpack_brick(packed.codec, packed.bytes, into));
  }
  Bytes into(brick.size());
  for (std::size_t size = 0; size < packed.bytes.size(); ++size) {
    EXPECT_FALSE(unpack_brick(packed.codec, std::span(packed.bytes).first(size), into)) << size;
  }
  for (int i = 0; i < 20'000; ++i) {
    Bytes changed = packed.bytes;
    for (int k = 0; k < 3; ++k)
      changed[random() % changed.size()] = static_cast<std::byte>(random());
    (void)unpack_brick(packed.codec, changed, into);
  }
  for (int codec = 0; codec < 16; ++codec) {
    (void)unpack_brick(static_cast<BrickCodec>(codec), packed.bytes, into);
  }
}

TEST(PackedBytes, RoundTripAnySize) {
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{10}, kPieceBytes, 3 * kPieceBytes + 8}) {
    Bytes bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i / 300);
    Bytes packed;
    pack_bytes(
        size, 2,
        [&](std::uint64_t offset, std::span<std::byte> into) {
          std::memcpy(into.data(), bytes.data() + offset, into.size());
        },
        [&](std::span<const std::byte> piece) {
          packed.insert(packed.end(), piece.begin(), piece.end());
        });
    Bytes back(size);
    ASSERT_TRUE(unpack_bytes("coarse", packed, back));
    EXPECT_TRUE(back == bytes);
    packed.push_back({});
    EXPECT_FALSE(unpack_bytes("coarse", packed, back));
    packed.resize(packed.size() / 2);
    if (size > 0) {
      EXPECT_FALSE(unpack_bytes("coarse", packed, back));
    }
  }
}

TEST(BrickOrder, ContainsEveryBrickOnceAndKeepsAlignedCubesContiguous) {
  for (const GridCounts& dims :
       {GridCounts{1, 1, 1}, GridCounts{16, 17, 300}, GridCounts{150, 90, 33}}) {
    const BrickLayout layout(dims);
    std::vector<std::size_t> order;
    in_file_order(layout, [&](std::size_t brick) { order.push_back(brick); });
    ASSERT_EQ(order.size(), layout.size());
    std::vector<bool> seen(layout.size());
    for (const std::size_t brick : order) seen[brick] = true;
    EXPECT_EQ(std::count(seen.begin(), seen.end(), true),
              static_cast<std::ptrdiff_t>(order.size()));
    // All bricks of a cube of 2^3 bricks are consecutive.
    std::size_t entered = 0;
    const BrickLayout cubes(layout.counts(), 2);
    std::size_t before = cubes.size();
    for (const std::size_t brick : order) {
      const GridCounts at = layout.at(brick);
      const std::size_t cube = cubes.index({at[0] / 2, at[1] / 2, at[2] / 2});
      entered += cube == before ? 0 : 1;
      before = cube;
    }
    EXPECT_EQ(entered, cubes.size());
  }
}

}  // namespace
}  // namespace multitetra
