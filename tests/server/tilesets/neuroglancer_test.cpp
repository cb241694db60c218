#include "server/tilesets/neuroglancer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

#include "tests/support/glb_reader.hpp"

namespace multitetra {
namespace {

DatasetInfo scan() {
  DatasetInfo info;
  info.name = "scan";
  info.dims = {300, 130, 65};
  info.spacing = {1, 2, 3};
  info.grid_exponent = 9;
  info.margin = 1;
  info.type = SampleType::kI16;
  info.suggested_isovalues = {300.5, 0};
  info.meaning = {.length_unit = "mm", .value_unit = "HU"};
  return info;
}

TEST(NeuroglancerSegment, RepresentsAnIsovalueExactly) {
  for (const double isovalue : {500.5, -300.0, 1e-30, 0.0, 1.0 / 3}) {
    const std::uint64_t segment = segment_of(isovalue);
    EXPECT_NE(segment, 0U);
    EXPECT_EQ(isovalue_of_segment(std::to_string(segment)), isovalue);
  }
  for (const char* none : {"", "x", "-5", "5.0", "9218868437227405312", "99999999999999999999"}) {
    EXPECT_FALSE(isovalue_of_segment(none)) << none;
  }
}

TEST(NeuroglancerProperties, NameTheSuggestedIsovalues) {
  const auto json = nlohmann::json::parse(segment_properties_json(scan()))["inline"];
  EXPECT_EQ(json["ids"][0], std::to_string(segment_of(300.5)));
  EXPECT_EQ(json["properties"][0]["values"], (std::vector<std::string>{"300.5 HU", "0 HU"}));
}

TEST(NeuroglancerImage, ServesOnlyScalesAndTheirChunks) {
  const auto json = nlohmann::json::parse(image_info_json(scan()));
  EXPECT_EQ(json["data_type"], "int16");
  ASSERT_EQ(json["scales"].size(), 3U);  // 300, 150 and 75 voxels along the longest side.
  EXPECT_EQ(json["scales"][1]["size"], (std::vector<int>{150, 65, 33}));
  EXPECT_EQ(json["scales"][1]["resolution"], (std::vector<double>{2e6, 4e6, 6e6}));
  const auto chunk = image_chunk_from(scan(), "2_2_2", "128-150_64-65_16-32");
  ASSERT_TRUE(chunk);
  EXPECT_EQ(chunk->step, 2);
  EXPECT_EQ(chunk->first, (std::array{128, 64, 16}));
  EXPECT_EQ(chunk->size, (std::array{22, 1, 16}));
  for (const auto& [scale, text] : {std::pair{"8_8_8", "0-64_0-64_0-16"},
                                    {"2_2_2", "0-63_0-64_0-16"},
                                    {"2_2_2", "1-65_0-64_0-16"},
                                    {"2_2_2", "192-256_0-64_0-16"},
                                    {"2_2_2", "0-64_0-64_0-16x"},
                                    {"2_2_2", "0-64_0-64"},
                                    {"2_2_2", ""},
                                    {"", "0-64_0-64_0-16"}}) {
    EXPECT_FALSE(image_chunk_from(scan(), scale, text)) << scale << " " << text;
  }
}

// As the format defines it: interleaved bits of x, y and z, x lowest.
std::uint64_t morton(const OctreeCube& cell) {
  std::uint64_t code = 0;
  for (int bit = 0; bit < 20; ++bit) {
    code |= static_cast<std::uint64_t>(cell.x >> bit & 1) << (3 * bit) |
            static_cast<std::uint64_t>(cell.y >> bit & 1) << (3 * bit + 1) |
            static_cast<std::uint64_t>(cell.z >> bit & 1) << (3 * bit + 2);
  }
  return code;
}

TEST(NeuroglancerManifest, ListsFragmentsByLevelInZOrder) {
  const Tileset tileset(scan(), {.isovalue = 1});
  MeshFragments fragments;
  for (const int exponent : {6, 7, 8, 9}) {
    const std::int32_t along = 1 << (9 - exponent);
    for (std::int32_t i = 0; i < along * along * along; i += 1 + i % 3) {
      const OctreeCube cell{exponent, i % along, i / along % along, i / along / along};
      fragments[cell] =
          std::make_shared<const std::string>(cell_name(cell) + std::string(morton(cell) % 5, '.'));
    }
  }
  const MeshFiles files = mesh_files_of(tileset, fragments);
  std::size_t at = 0;
  const auto u32 = [&] {
    std::uint32_t value = 0;
    std::memcpy(&value, files.manifest.data() + at, 4);
    at += 4;
    return value;
  };
  const auto f32 = [&] { return std::bit_cast<float>(u32()); };
  EXPECT_EQ(f32(), 64e6F);
  EXPECT_EQ(f32(), 128e6F);
  EXPECT_EQ(f32(), 192e6F);
  EXPECT_EQ(f32(), -0.5e6F);  // The grid begins one step before the first sample.
  at += 8;
  ASSERT_EQ(u32(), 4U);
  float below = 0;
  for (int exponent = 6; exponent <= 9; ++exponent) {
    const float scale = f32();
    EXPECT_GT(scale, below);
    EXPECT_GE(static_cast<double>(scale), 0.999999e6 * tileset.error_bound(exponent));
    below = scale;
  }
  at += 4 * 3 * 4;
  std::array<std::uint32_t, 4> counts{};
  for (std::uint32_t& count : counts) count = u32();
  std::size_t offset = 0;
  std::size_t seen = 0;
  for (std::size_t level = 0; level < 4; ++level) {
    std::vector<OctreeCube> cells(counts[level], OctreeCube{static_cast<int>(level) + 6, 0, 0, 0});
    for (const auto axis : {&OctreeCube::x, &OctreeCube::y, &OctreeCube::z}) {
      for (OctreeCube& cell : cells) cell.*axis = static_cast<std::int32_t>(u32());
    }
    EXPECT_TRUE(std::is_sorted(cells.begin(), cells.end(),
                               [](const auto& a, const auto& b) { return morton(a) < morton(b); }));
    for (const OctreeCube& cell : cells) {
      const std::uint32_t size = u32();
      EXPECT_EQ(files.data.substr(offset, size), *fragments.at(cell));
      offset += size;
      ++seen;
    }
  }
  EXPECT_EQ(at, files.manifest.size());
  EXPECT_EQ(offset, files.data.size());
  EXPECT_EQ(seen, fragments.size());
}

TEST(NeuroglancerFragment, HasIntegerCoordinatesAcrossItsCell) {
  const OctreeCube cell{6, 1, 0, 2};
  constexpr std::int32_t kSide = 1 << 11;
  const LatticeMesh mesh{
      .resolution = 5,
      .vertices = {{kSide, 0, 2 * kSide}, {2 * kSide, 0, 2 * kSide}, {kSide, kSide / 2, 3 * kSide}},
      .triangles = {{0, 1, 2}}};
  const std::string bytes = mesh_fragment(mesh, cell);
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  ASSERT_TRUE(decoded.ok());
  const draco::Mesh& found = *decoded.value();
  EXPECT_EQ(found.num_attributes(), 1);
  const draco::PointAttribute* position = found.attribute(0);
  EXPECT_EQ(position->data_type(), draco::DT_INT32);
  std::vector<std::array<std::int32_t, 3>> points(found.num_points());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    position->GetMappedValue(draco::PointIndex(i), points[i].data());
  }
  std::sort(points.begin(), points.end());
  EXPECT_EQ(points, (std::vector<std::array<std::int32_t, 3>>{
                        {0, 0, 0}, {0, 32768, 65535}, {65535, 0, 0}}));
  EXPECT_TRUE(mesh_fragment({}, cell).empty());
}

}  // namespace
}  // namespace multitetra
