#include "server/tilesets/neuroglancer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

#include "server/tilesets/neuroglancer_image.hpp"
#include "tests/support/glb_reader.hpp"

namespace multitetra {
namespace {

DatasetInfo scan() {
  DatasetInfo info;
  info.name = "scan";
  info.dims = {300, 130, 65};
  info.spacing = {1, 2, 3};
  info.index_to_world.columns = {Vec3{1, 0, 0}, Vec3{0, 2, 0}, Vec3{0, 0, 3}};
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
  EXPECT_EQ(chunk->to_index({1, 0, 0}), (Vec3{258, 128, 32}));
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

// A place in the image, in nanometres from the origin of the world, of the first sample.
Vec3 first_sample_in_image(const DatasetInfo& info) {
  const Vec3 middle = scaled(info.spacing, 0.5e6);  // Of voxel (0, 0, 0) of the manifest.
  return manifest_to_image(info)(middle);
}

// The same samples in any order lie at the same places of the world.
TEST(NeuroglancerImage, IsInItsPlaceHoweverSamplesAreStored) {
  DatasetInfo info = scan();
  info.index_to_world.translation = {-149.5, 21, 97.5};
  const auto scales = nlohmann::json::parse(image_info_json(info))["scales"];
  EXPECT_EQ(scales[0]["voxel_offset"], (std::vector<int>{-150, 10, 32}));
  EXPECT_EQ(scales[2]["voxel_offset"], (std::vector<int>{-38, 2, 8}));
  EXPECT_EQ(first_sample_in_image(info), (Vec3{-149.5e6, 21e6, 97.5e6}));

  DatasetInfo mirrored = info;  // x backwards, and stored last.
  mirrored.dims = {130, 65, 300};
  mirrored.spacing = {2, 3, 1};
  mirrored.index_to_world = {.columns = {Vec3{0, 2, 0}, Vec3{0, 0, 3}, Vec3{-1, 0, 0}},
                             .translation = {149.5, 21, 97.5}};
  EXPECT_EQ(image_info_json(mirrored), image_info_json(info));
  const auto chunk = image_chunk_from(mirrored, "1_1_1", "-86--22_10-74_48-64");
  ASSERT_TRUE(chunk);
  EXPECT_EQ(chunk->size, (std::array{64, 64, 16}));
  EXPECT_EQ(chunk->to_index({0, 1, 2}), (Vec3{1, 18, 235}));
  EXPECT_FALSE(image_chunk_from(mirrored, "1_1_1", "0-64_0-64_0-16"));
  EXPECT_EQ(first_sample_in_image(mirrored), (Vec3{149.5e6, 21e6, 97.5e6}));
  const auto transform = nlohmann::json::parse(mesh_info_json(mirrored))["transform"];
  EXPECT_EQ(transform[2], -1);
  EXPECT_EQ(transform[4], 1);
}

TEST(NeuroglancerImage, OfARotatedVolumeIsResampledOntoTheAxes) {
  DatasetInfo info = scan();
  const double c = std::cos(0.3);
  const double s = std::sin(0.3);
  info.index_to_world.columns = {Vec3{c, s, 0}, Vec3{-2 * s, 2 * c, 0}, Vec3{0, 0, 3}};
  const auto scale = nlohmann::json::parse(image_info_json(info))["scales"][0];
  EXPECT_EQ(scale["size"], (std::vector<int>{362, 168, 65}));
  EXPECT_EQ(scale["voxel_offset"], (std::vector<int>{-77, 0, 0}));
  const auto chunk = image_chunk_from(info, "1_1_1", "-13-51_0-64_0-16");
  ASSERT_TRUE(chunk);
  // A voxel, an index and a place of a manifest that belong together.
  const Vec3 index = chunk->to_index({20, 30, 5});
  const Vec3 world = info.index_to_world(index);
  EXPECT_NEAR(world[1], 60, 1e-9);
  EXPECT_NEAR(world[2], 15, 1e-9);
  const Vec3 place = manifest_to_image(info)(
      {1e6 * (index[0] + 0.5), 2e6 * (index[1] + 0.5), 3e6 * (index[2] + 0.5)});
  EXPECT_NEAR(place[0], 1e6 * (-13 + 20 + 0.5), 1e-3);
  EXPECT_NEAR(place[1], 2e6 * 30.5, 1e-3);
  EXPECT_NEAR(place[2], 3e6 * 5.5, 1e-3);
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
