#include "server/dataset/objects/object_layout.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/dataset/statistics.hpp"
#include "tests/support/fields.hpp"

namespace multitetra {
namespace {

TEST(SampleObjects, HoldEveryBrickOnceOneAfterTheOther) {
  for (const GridCounts dims : {GridCounts{1, 1, 1}, GridCounts{128, 128, 128},
                                GridCounts{300, 129, 40}, GridCounts{17, 260, 257}}) {
    const SampleObjects objects(dims, SampleType::kI16);
    std::vector<int> seen(objects.bricks().size());
    std::uint64_t bytes = 0;
    for (std::size_t object = 0; object < objects.size(); ++object) {
      std::uint32_t offset = 0;
      for (const std::size_t brick : objects.bricks_of(object)) {
        const BrickInObject at = objects.place(brick);
        EXPECT_EQ(at.object, object);
        EXPECT_EQ(at.offset, offset);
        EXPECT_EQ(at.size, 2 * objects.bricks().volume(objects.bricks().at(brick)));
        offset += at.size;
        ++seen[brick];
      }
      EXPECT_EQ(offset, objects.bytes_of(object));
      bytes += offset;
    }
    EXPECT_TRUE(std::all_of(seen.begin(), seen.end(), [](int times) { return times == 1; }));
    EXPECT_EQ(bytes, 2U * static_cast<std::uint64_t>(dims[0]) *
                         static_cast<std::uint64_t>(dims[1]) * static_cast<std::uint64_t>(dims[2]));
  }
}

TEST(SampleObjects, FollowEachOtherInMortonOrder) {
  const SampleObjects objects({300, 300, 300}, SampleType::kU8);
  for (std::size_t object = 1; object < objects.size(); ++object) {
    EXPECT_LT(morton_number(objects.box_of(object - 1)), morton_number(objects.box_of(object)));
  }
}

// Bricks of the spectrum of some sizes, as an index has them.
std::vector<BrickPlace> index_with(const DatasetInfo& info, std::uint32_t most, unsigned seed) {
  std::vector<BrickPlace> index(SpectrumLayout(info).size());
  std::mt19937 random(seed);
  std::uint64_t offset = 0;
  for (BrickPlace& place : index) {
    if (random() % 5 == 0) continue;
    place = {.offset = offset, .size = 1 + static_cast<std::uint32_t>(random() % most)};
    offset += place.size;
  }
  return index;
}

TEST(SpectrumObjects, HoldEveryBrickThatIsNotEmptyAndAreSmall) {
  const DatasetInfo info = describe(testing::fields::noise({300, 40, 260}, 1), "noise", {}, 0);
  for (const std::uint32_t most : {10U, 60000U, 3000000U}) {
    const std::vector<BrickPlace> index = index_with(info, most, most);
    const SpectrumObjects objects(info, index);
    std::vector<int> seen(index.size());
    for (std::size_t object = 0; object < objects.size(); ++object) {
      std::uint32_t offset = 0;
      for (const std::size_t brick : objects.bricks_of(object)) {
        const BrickInObject at = objects.place(brick);
        EXPECT_EQ(at.object, object);
        EXPECT_EQ(at.offset, offset);
        EXPECT_EQ(at.size, index[brick].size);
        offset += at.size;
        ++seen[brick];
      }
      EXPECT_GT(offset, 0U);
      EXPECT_LE(offset, SpectrumObjects::kSpectrumObjectBytes);
    }
    for (std::size_t i = 0; i < index.size(); ++i) EXPECT_EQ(seen[i], index[i].size > 0) << i;
  }
}

TEST(SpectrumObjects, OfAnEmptySpectrumAreNone) {
  const DatasetInfo info = describe(testing::fields::noise({30, 30, 30}, 1), "noise", {}, 0);
  EXPECT_EQ(SpectrumObjects(info, std::vector<BrickPlace>(SpectrumLayout(info).size())).size(), 0U);
}

}  // namespace
}  // namespace multitetra
