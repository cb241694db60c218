#include "server/tilesets/tileset_json.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/dataset/dataset_info.hpp"

namespace multitetra {
namespace {

DatasetInfo head() {
  DatasetInfo info;
  info.name = "head";
  info.dims = {200, 100, 50};
  info.spacing = {1, 1, 1.5};
  info.index_to_world = {.columns = {Vec3{0, 1, 0}, Vec3{-1, 0, 0}, Vec3{0, 0, 1.5}},
                         .translation = {10, 20, 30}};
  info.grid_exponent = 8;
  info.meaning.length_unit = "mm";
  return info;
}

nlohmann::json parsed(const Tileset& tileset, const OctreeCube& cell, const CellFacts& facts,
                      const char* folder = "") {
  return nlohmann::json::parse(tileset_json(tileset, cell, facts, folder));
}

TEST(TilesetJson, LinksToCrossedOctants) {
  const Tileset tileset(head(), {.isovalue = 3});
  const auto json = parsed(tileset, tileset.root(), {.crossed_octants = 0x03}, "id/");
  EXPECT_EQ(json["asset"]["version"], "1.1");
  const auto& root = json["root"];
  EXPECT_EQ(root["refine"], "REPLACE");
  EXPECT_EQ(root["content"]["uri"], "id/8-0-0-0.glb");
  ASSERT_EQ(root["children"].size(), 2U);
  EXPECT_EQ(root["children"][0]["content"]["uri"], "id/7-0-0-0.json");
  EXPECT_EQ(root["children"][1]["content"]["uri"], "id/7-1-0-0.json");
  // A tile that links to another tileset has the error and the box of that tileset's root.
  const auto child = parsed(tileset, {7, 1, 0, 0}, {.crossed_octants = 0xFF});
  EXPECT_EQ(child["root"]["geometricError"], root["children"][1]["geometricError"]);
  EXPECT_EQ(child["root"]["boundingVolume"], root["children"][1]["boundingVolume"]);
  EXPECT_LT(child["root"]["geometricError"], root["geometricError"]);
  EXPECT_LT(root["geometricError"], json["geometricError"]);
  EXPECT_FALSE(child["root"].contains("transform"));
  EXPECT_FALSE(
      parsed(tileset, {6, 1, 0, 0}, {.crossed_octants = 0xFF})["root"].contains("children"));
}

TEST(TilesetJson, TransformsMetresWithoutScaling) {
  const Tileset tileset(head(), {.isovalue = 3});
  const auto root = parsed(tileset, tileset.root(), {})["root"];
  const std::vector<double> transform = root["transform"];
  const std::vector<double> expected = {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 1e-2, 2e-2, 3e-2, 1};
  ASSERT_EQ(transform.size(), 16U);
  for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(transform[i], expected[i], 1e-15) << i;
  EXPECT_NEAR(root["geometricError"].get<double>(), 1e-3 * tileset.error_bound(8), 1e-12);
  EXPECT_EQ(root["extras"]["isCertified"], false);
}

TEST(TilesetJson, NestsBoxesOfChildrenInThoseOfParents) {
  const Tileset tileset(head(), {.isovalue = 3});
  const auto box = [](const nlohmann::json& tile) {
    return tile["boundingVolume"]["box"].get<std::vector<double>>();
  };
  const auto root = parsed(tileset, tileset.root(), {.crossed_octants = 0xFF})["root"];
  constexpr double mm = 1e-3;
  EXPECT_EQ(box(root), (std::vector<double>{99.5 * mm, 49.5 * mm, 1.5 * mm * 24.5, 99.5 * mm, 0, 0,
                                            0, 49.5 * mm, 0, 0, 0, 1.5 * mm * 24.5}));
  const auto outer = box(root);
  for (const auto& child : root["children"]) {
    const auto inner = box(child);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double half = inner[3 + 4 * axis];
      EXPECT_GT(half, 0);
      if (half < 0.1 * mm) continue;  // Beyond the data, never marked as crossed.
      EXPECT_LE(std::abs(inner[axis] - outer[axis]) + half, outer[3 + 4 * axis] + 1e-12);
    }
  }
}

TEST(TilesetJson, HasNoContentForAnEmptySurface) {
  const Tileset tileset(head(), {.isovalue = 3});
  const auto json = parsed(tileset, tileset.root(), {.is_empty = true});
  EXPECT_FALSE(json["root"].contains("content"));
  EXPECT_FALSE(json["root"].contains("children"));
  // A preview too coarse to show anything is refined at any distance.
  EXPECT_EQ(json["root"]["geometricError"], json["geometricError"]);
}

}  // namespace
}  // namespace multitetra
