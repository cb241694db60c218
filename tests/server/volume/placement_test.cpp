#include "server/volume/placement.hpp"

#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include "server/volume/volume_files.hpp"
#include "tests/server/volume/written_volumes.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

// Spacings of 2 and 3 mm along axes that are rotated by a quarter turn around z, in LPS.
ImageHeader turned_header() {
  ImageHeader header{.values = kNumbersAsStored,
                     .meaning = {.space = WorldSpace::kLps, .length_unit = "mm"}};
  set_axes(header, {Vec3{0, 2, 0}, Vec3{-3, 0, 0}, Vec3{0, 0, 1}}, stated({10, 20, 30}));
  return header;
}

TEST(Placement, ReplacesOnlyGivenValues) {
  const ImageHeader before = turned_header();
  ImageHeader header = before;
  place(header, {});
  EXPECT_EQ(header.geometry.axes, before.geometry.axes);
  EXPECT_EQ(header.geometry.origin, before.geometry.origin);
  EXPECT_EQ(header.meaning, before.meaning);
  place(header, {.length_unit = "µm"});
  EXPECT_EQ(header.geometry.axes, before.geometry.axes);
  EXPECT_EQ(header.geometry.origin, before.geometry.origin);
  EXPECT_EQ(header.meaning.length_unit, "µm");
}

TEST(Placement, KeepsDirectionsAndOriginWithASpacing) {
  ImageHeader header = turned_header();
  place(header, {.spacing = Vec3{0.5, 0.25, 4}});
  EXPECT_EQ(header.geometry.spacing, stated({0.5, 0.25, 4}));
  EXPECT_EQ(header.geometry.axes[0], (Vec3{0, 0.5, 0}));
  EXPECT_EQ(header.geometry.axes[1], (Vec3{-0.25, 0, 0}));
  EXPECT_EQ(header.geometry.origin, stated({10, 20, 30}));
}

TEST(Placement, SuppliesAMissingSpacing) {
  ImageHeader header{.values = kNumbersAsStored};
  EXPECT_EQ(header.geometry.spacing, kNotStated);
  place(header, {.spacing = Vec3{1, 2, 3}});
  EXPECT_NO_THROW(check_header("lacking", header));
  EXPECT_EQ(header.geometry.axes[2], (Vec3{0, 0, 3}));
}

TEST(Placement, RotatesAllWorldCoordinatesWithOrient) {
  ImageHeader header = turned_header();
  // Directions along y become -z, and directions along z become y.
  place(header, {.orient = axis_directions_from("x,-z,y")});
  EXPECT_EQ(header.geometry.axes[0], (Vec3{0, 0, -2}));
  EXPECT_EQ(header.geometry.axes[1], (Vec3{-3, 0, 0}));
  EXPECT_EQ(header.geometry.axes[2], (Vec3{0, 1, 0}));
  EXPECT_EQ(header.geometry.origin, stated({10, 30, -20}));
  EXPECT_EQ(header.geometry.spacing, stated({2, 3, 1}));
  place(header, {.orient = axis_directions_from("x,z,-y"), .origin = Vec3{1, 2, 3}});
  EXPECT_EQ(header.geometry.axes, turned_header().geometry.axes);
  EXPECT_EQ(header.geometry.origin, stated({1, 2, 3})) << "an origin is not turned";
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
  ImageHeader header{.values = kNumbersAsStored};
  place(header, {.origin = Vec3{1, 2, 3}, .space = WorldSpace::kRas});
  EXPECT_EQ(header.meaning.space, WorldSpace::kLps);
  EXPECT_EQ(header.geometry.axes[0], (Vec3{-1, 0, 0}));
  EXPECT_EQ(header.geometry.origin, stated({-1, -2, 3}));
}

TEST(Placement, NamesTheAxesOfTheFilesOwnCoordinates) {
  // A file in RAS, as NIfTI: its reader turned it.
  ImageHeader turned{.values = kNumbersAsStored};
  std::array<Vec3, 3> steps = {Vec3{2, 0, 0}, {0, 3, 0}, {0, 0, 4}};
  Vec3 origin = {10, 20, 30};
  ras_to_lps(turned, steps, origin);
  set_axes(turned, steps, stated(origin));
  turned.meaning.space = WorldSpace::kLps;
  for (const auto& [space, sign] :
       {std::pair{WorldSpace::kRas, -1.0}, {WorldSpace::kLps, 1.0}, {WorldSpace::kUnnamed, 1.0}}) {
    ImageHeader header = turned;
    place(header, {.space = space});
    EXPECT_EQ(header.geometry.axes[0], (Vec3{2 * sign, 0, 0}));
    EXPECT_EQ(header.geometry.origin, stated({10 * sign, 20 * sign, 30}));
  }
}

TEST(Placement, SettlesWhatNobodyStatesAndNamesIt) {
  ImageHeader header{
      .dims = {4, 3, 2}, .values = kNumbersAsStored, .meaning = {.length_unit = "mm"}};
  EXPECT_EQ(settled(header).meaning.geometry, GeometryBasis::kAssumed);
  EXPECT_EQ(settled(header).meaning.assumed, "spacing along x, y and z, origin");
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  set_box_axes(header, {0.5, -1, kNan}, {2, -0.5, 0});
  const VolumeHeader partly = settled(header);
  EXPECT_EQ(partly.spacing, (Vec3{2, 0.5, 1}));
  EXPECT_EQ(partly.index_to_world({1, 1, 1}), (Vec3{2.5, -1.5, 1}));
  EXPECT_EQ(geometry_text(partly.meaning), "partly (spacing along z, origin are assumed)");
  EXPECT_EQ(fact_notices("v.x", header),
            std::vector<std::string>{"'v.x': the file states no spacing along z; 1 mm is assumed. "
                                     "Give it with --spacing."});
  place(header, {.spacing = Vec3{2, 2, 2}, .origin = Vec3{0, 0, 0}});
  EXPECT_EQ(geometry_text(settled(header).meaning), "stated");
  EXPECT_TRUE(fact_notices("v.x", header).empty());
  ImageHeader one_slice{.dims = {4, 3, 1}, .values = kNumbersAsStored};
  set_box_axes(one_slice, {0, 0, std::nullopt}, {1, 1, std::nullopt});
  EXPECT_EQ(settled(one_slice).meaning.geometry, GeometryBasis::kStated) << "one slice has no step";
}

TEST(Placement, TellsContradictionsUnlessTheFactIsGiven) {
  ImageHeader header{.dims = {1, 1, 1}, .values = kNumbersAsStored};
  header.contradictions = {{Fact::kSpacing, "it says 1 and 2"}, {Fact::kSign, "it says both"}};
  EXPECT_EQ(fact_notices("v.x", header).size(), 2U);
  place(header, {.spacing = Vec3{1, 1, 1}});
  EXPECT_EQ(fact_notices("v.x", header), std::vector<std::string>{"'v.x': it says both."});
}

TEST(Placement, ConvertsAxesOfDifferentUnitsToOne) {
  ImageHeader header{.dims = {2, 2, 2}, .values = kNumbersAsStored};
  set_box_axes(header, {1, 1, 1}, {2, 2, 2});
  set_units_of_axes(header, {"um", "nanometer", ""});
  EXPECT_EQ(header.meaning.length_unit, "µm");
  EXPECT_DOUBLE_EQ(*header.geometry.spacing[1], 2e-3);
  EXPECT_DOUBLE_EQ(header.geometry.axes[1][1], 2e-3);
  EXPECT_DOUBLE_EQ(*header.geometry.origin[1], 1e-3);
  set_units_of_axes(header, {"mm", "degree", "mm"});
  EXPECT_EQ(header.meaning.length_unit, "");
  ASSERT_EQ(header.contradictions.size(), 1U);
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
