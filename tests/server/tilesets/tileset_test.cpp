#include "server/tilesets/tileset.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "common/request/lattice_limit.hpp"
#include "server/tilesets/detail/metres.hpp"

namespace multitetra {
namespace {

DatasetInfo info_of(std::int32_t exponent) {
  DatasetInfo info;
  info.name = "field";
  info.spacing = {0.5, 1, 2};
  info.grid_exponent = exponent;
  info.dims.fill((1 << exponent) + 1);
  return info;
}

TEST(TilesetSettings, RoundTrip) {
  for (const TilesetSettings& settings :
       {TilesetSettings{.isovalue = 500.5},
        {.isovalue = -1e-30, .error = 0},
        {.isovalue = 0.1, .error = 1e9},
        {.isovalue = 2, .codec = CellCodec::kMeshopt},
        {.isovalue = 2, .error = 1, .codec = CellCodec::kMeshopt}}) {
    EXPECT_EQ(tileset_settings_from(text_of(settings)), settings) << text_of(settings);
  }
  EXPECT_EQ(tileset_settings_from("7")->error, 0.25);
}

TEST(TilesetSettings, RejectsInvalidTextWithAnExample) {
  for (const char* text : {"", "x", "1 ", "nan", "inf", "1e999", "1,", "1,error",
                           "1,error=", "1,error=-1", "1,error=nan", "1,error=1,error=2", "1,tau=2",
                           "1,codec=zip", "1,codec=meshopt,error=1", "1,codec=meshopt,"}) {
    const auto settings = tileset_settings_from(text);
    ASSERT_FALSE(settings) << text;
    EXPECT_EQ(settings.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(settings.error().text.find("500.5,error=0.5,codec=meshopt"), std::string::npos);
  }
}

TEST(CellName, RoundTripsAndRejectsOtherTexts) {
  const OctreeCube cell{9, 0, 31, 7};
  EXPECT_EQ(cell_name(cell), "9-0-31-7");
  EXPECT_EQ(cell_from("9-0-31-7"), cell);
  for (const char* text : {"", "9", "9-0-31", "9-0-31-7-", "09-0-31-7", "9-0-31-+7", "9-0-31-7 ",
                           "9-0-31-99999999999", "9--0-31-7", "-9-0-31-7x"}) {
    EXPECT_FALSE(cell_from(text)) << text;
  }
}

TEST(Tileset, LowersTheErrorPerLevelAndMakesValidRequests) {
  for (std::int32_t exponent = 1; exponent <= 14; ++exponent) {
    for (const double error : {0.0, 0.25, 3.0, 1e6}) {
      SCOPED_TRACE(::testing::Message() << "exponent " << exponent << ", error " << error);
      const Tileset tileset(info_of(exponent), {.isovalue = 1, .error = error});
      double above = std::numeric_limits<double>::infinity();
      for (int level = exponent; level >= tileset.leaf_exponent(); --level) {
        EXPECT_LT(tileset.error_bound(level), above);
        above = tileset.error_bound(level);
        const IsosurfaceRequest request = tileset.request({level, 0, 0, 0});
        EXPECT_TRUE(validated(request));
        EXPECT_TRUE(check_cell(*request.cell, tileset.info()));
        EXPECT_TRUE(check_lattice(request, tileset.info()));
        EXPECT_EQ(tileset.is_preview(level), request.topology_tolerance > 0);
        EXPECT_GE(above, request.error * voxel_length(tileset.info()));
        // A cell consists of at most 2^8 points per side.
        EXPECT_LE(request.cell->cube.side() / request.cell->finest_spacing, 256);
      }
      EXPECT_FALSE(tileset.is_preview(tileset.leaf_exponent()));
      EXPECT_EQ(tileset.request({tileset.leaf_exponent(), 0, 0, 0}).error, error);
    }
  }
}

TEST(Tileset, ContainsTheCellsOfEachLevelInsideTheGrid) {
  const Tileset tileset(info_of(8), {});
  EXPECT_TRUE(tileset.contains(tileset.root()));
  EXPECT_TRUE(tileset.contains({6, 3, 0, 3}));
  EXPECT_FALSE(tileset.contains({6, 4, 0, 3}));
  EXPECT_FALSE(tileset.contains({6, 0, -1, 3}));
  EXPECT_FALSE(tileset.contains({5, 0, 0, 0}));
  EXPECT_FALSE(tileset.contains({9, 0, 0, 0}));
}

TEST(Tileset, ChangesItsIdWithTheContent) {
  DatasetInfo info = info_of(7);
  std::set<std::string> ids = {Tileset(info, {}).id()};
  info.content_id = 5;
  ids.insert(Tileset(info, {}).id());
  info.meaning.length_unit = "mm";
  ids.insert(Tileset(info, {}).id());
  info.index_to_world.translation[2] = 4;
  ids.insert(Tileset(info, {}).id());
  EXPECT_EQ(ids.size(), 4U);
  EXPECT_EQ(Tileset(info, {.isovalue = 3}).id(), *ids.find(Tileset(info, {}).id()));
}

TEST(Metres, ConvertsTheUnitsInFiles) {
  EXPECT_EQ(metres_of("mm"), 1e-3);
  EXPECT_EQ(metres_of("Micrometers"), 1e-6);
  EXPECT_EQ(metres_of("\xC2\xB5m"), 1e-6);
  EXPECT_EQ(metres_of("\xC3\x85"), 1e-10);
  EXPECT_EQ(metres_of("m"), 1);
  for (const char* none : {"", "HU", "s", "ms", "pixel"}) EXPECT_FALSE(metres_of(none)) << none;
}

}  // namespace
}  // namespace multitetra
