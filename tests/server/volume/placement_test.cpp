#include "server/volume/placement.hpp"

#include <utility>

#include <gtest/gtest.h>

#include "server/volume/volume_files.hpp"
#include "tests/server/volume/written_volumes.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

// Spacings of 2 and 3 mm along axes that are rotated by a quarter turn around z, in LPS.
ImageHeader turned_header() {
  ImageHeader header{.meaning = {.space = WorldSpace::kLps, .length_unit = "mm", .value_unit = ""}};
  set_axes(header, {Vec3{0, 2, 0}, Vec3{-3, 0, 0}, Vec3{0, 0, 1}}, {10, 20, 30});
  return header;
}

TEST(Placement, ReplacesOnlyGivenValues) {
  const ImageHeader before = turned_header();
  ImageHeader header = before;
  place(header, {});
  EXPECT_EQ(header.index_to_world, before.index_to_world);
  EXPECT_EQ(header.meaning, before.meaning);
  place(header, {.length_unit = "µm"});
  EXPECT_EQ(header.index_to_world, before.index_to_world);
  EXPECT_EQ(header.meaning.length_unit, "µm");
}

TEST(Placement, KeepsDirectionsAndOriginWithASpacing) {
  ImageHeader header = turned_header();
  place(header, {.spacing = Vec3{0.5, 0.25, 4}});
  EXPECT_EQ(header.spacing, (Vec3{0.5, 0.25, 4}));
  EXPECT_EQ(header.index_to_world.columns[0], (Vec3{0, 0.5, 0}));
  EXPECT_EQ(header.index_to_world.columns[1], (Vec3{-0.25, 0, 0}));
  EXPECT_EQ(header.index_to_world.translation, (Vec3{10, 20, 30}));
}

TEST(Placement, SuppliesAMissingSpacing) {
  ImageHeader header;
  header.spacing = {0, 0, 0};
  header.index_to_world.columns = {};
  for (Vec3& column : header.index_to_world.columns) column = {0, 0, 0};
  place(header, {.spacing = Vec3{1, 2, 3}});
  EXPECT_NO_THROW(check_header("lacking", header));
  EXPECT_EQ(header.index_to_world.columns[2], (Vec3{0, 0, 3}));
}

TEST(Placement, RotatesAllWorldCoordinatesWithOrient) {
  ImageHeader header = turned_header();
  // Directions along y become -z, and directions along z become y.
  place(header, {.orient = axis_directions_from("x,-z,y")});
  EXPECT_EQ(header.index_to_world.columns[0], (Vec3{0, 0, -2}));
  EXPECT_EQ(header.index_to_world.columns[1], (Vec3{-3, 0, 0}));
  EXPECT_EQ(header.index_to_world.columns[2], (Vec3{0, 1, 0}));
  EXPECT_EQ(header.index_to_world.translation, (Vec3{10, 30, -20}));
  EXPECT_EQ(header.spacing, (Vec3{2, 3, 1}));
  place(header, {.orient = axis_directions_from("x,z,-y"), .origin = Vec3{1, 2, 3}});
  EXPECT_EQ(header.index_to_world.columns, turned_header().index_to_world.columns);
  EXPECT_EQ(header.index_to_world.translation, (Vec3{1, 2, 3})) << "an origin is not turned";
}

TEST(AxisDirections, ContainEachAxisOnce) {
  EXPECT_EQ(axis_directions_from("x,-z,+y"),
            (AxisDirections{Vec3{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}));
  for (const char* text :
       {"", "x", "x,y", "x,y,y", "x,y,z,x", "x,y,z,", "x,y,-", "x,y,w", "xy,z,x", "--x,y,z"}) {
    EXPECT_FALSE(axis_directions_from(text)) << text;
  }
}

TEST(AxisDirections, MirrorAfterAnOddNumberOfFlipsAndSwaps) {
  for (const char* turn : {"x,y,z", "x,-z,y", "-x,-y,z", "y,z,x", "-y,-x,-z"}) {
    EXPECT_FALSE(is_mirror(axis_directions_from(turn).value())) << turn;
  }
  for (const auto& [mirror, turns] : {std::pair{"x,y,-z", "-x,y,-z or x,-y,-z"},
                                      {"-x,y,z", "-x,-y,z"},
                                      {"y,x,z", "-y,x,z or y,-x,z"},
                                      {"-x,-y,-z", "x,-y,-z or -x,y,-z"}}) {
    EXPECT_TRUE(is_mirror(axis_directions_from(mirror).value())) << mirror;
    EXPECT_EQ(nearest_rotations(axis_directions_from(mirror).value()), turns);
  }
}

TEST(Placement, ConvertsRasToLpsIncludingTheOrigin) {
  ImageHeader header;
  place(header, {.origin = Vec3{1, 2, 3}, .space = WorldSpace::kRas});
  EXPECT_EQ(header.meaning.space, WorldSpace::kLps);
  EXPECT_EQ(header.index_to_world.columns[0], (Vec3{-1, 0, 0}));
  EXPECT_EQ(header.index_to_world.translation, (Vec3{-1, -2, 3}));
}

TEST(Placement, AppliesToFilesOfAnyFormat) {
  const TemporaryFolder folder;
  const auto file = folder.file(
      "v.nrrd", nrrd("dimension: 3\nsizes: 4 3 2\nencoding: raw\nendian: little\ntype: uint8\n",
                     packed<std::uint8_t>(values())));
  const Volume volume = read_volume(
      file,
      {.placement = {.spacing = Vec3{2, 2, 5}, .origin = Vec3{1, 1, 1}, .length_unit = "nm"}});
  EXPECT_EQ(volume.spacing, (Vec3{2, 2, 5}));
  EXPECT_EQ(volume.index_to_world.translation, (Vec3{1, 1, 1}));
  EXPECT_EQ(volume.meaning.length_unit, "nm");
}

}  // namespace
}  // namespace multitetra
