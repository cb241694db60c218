// Parsing the request options that the client and server programs share.
#include "common/cli/surface_options.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "common/json/json_report.hpp"
#include "common/mesh/components.hpp"

namespace multitetra {
namespace {

DatasetInfo info() {
  DatasetInfo info;
  info.name = "fuel";
  info.suggested_isovalues = {60.5};
  return info;
}

constexpr std::initializer_list<FieldGroup> kRequested = {
    FieldGroup::kSurface, FieldGroup::kThresholds, FieldGroup::kSize};

Result<IsosurfaceRequest> request(std::vector<std::string> words) {
  Command command("", "test");
  SurfaceArguments arguments;
  add_request_options(command, arguments, kRequested);
  std::reverse(words.begin(), words.end());  // CLI11 expects reversed arguments.
  command.app().parse(words);
  return request_of(arguments, info());
}

std::string refusal(std::vector<std::string> words) {
  const auto refused = request(std::move(words));
  return refused ? "accepted" : refused.error().text;
}

TEST(SurfaceOptions, DefaultToASimplifiedSurface) {
  EXPECT_EQ(request({}).value(),
            (IsosurfaceRequest{.isovalue = 60.5, .error = 0.25, .simplify = true}));
  EXPECT_EQ(request({"--simplify", "off"}).value(),
            (IsosurfaceRequest{.isovalue = 60.5, .error = 0.25}));
  EXPECT_EQ(request({"--intersection-free"}).value(),
            (IsosurfaceRequest{
                .isovalue = 60.5, .error = 0.25, .simplify = true, .intersection_free = true}));
}

TEST(SurfaceOptions, AcceptSeveralIsovalues) {
  const auto isovalues_of = [](std::vector<std::string> words) {
    Command command("", "test");
    SurfaceArguments arguments;
    add_request_options(command, arguments, kRequested);
    std::reverse(words.begin(), words.end());
    command.app().parse(words);
    std::vector<double> isovalues;
    const auto requests = requests_from(arguments, info());
    for (const IsosurfaceRequest& each : *requests) {
      EXPECT_EQ(each.error, arguments.query.request.error);
      isovalues.push_back(each.isovalue);
    }
    return isovalues;
  };
  EXPECT_EQ(isovalues_of({}), std::vector{60.5});
  EXPECT_EQ(isovalues_of({"--isovalue", "-7"}), std::vector{-7.0});
  EXPECT_EQ(isovalues_of({"--isovalue", "-7,1e3", "--error", "2"}), (std::vector{-7.0, 1e3}));
  EXPECT_EQ(isovalues_of({"--isovalue", "1", "--isovalue", "2"}), (std::vector{1.0, 2.0}));
  EXPECT_EQ(request({"--isovalue", "-7"}).value().isovalue, -7);
  EXPECT_NE(refusal({"--isovalue", "1,2"}).find("one isovalue"), std::string::npos);
}

TEST(SurfaceOptions, NameAnErrorByItsQuality) {
  EXPECT_EQ(request({"--quality", "draft"}).value().error, 2);
  EXPECT_EQ(request({"--quality", "normal"}).value().error, 0.5);
  EXPECT_EQ(request({"--quality", "fine"}).value().error, 0.25);
  EXPECT_EQ(request({"--quality", "exact"}).value().error, 0);
  EXPECT_NE(refusal({"--quality", "fine", "--error", "1"}).find("exclude each other"),
            std::string::npos);
  EXPECT_NE(refusal({"--quality", "fine", "--unit", "world"}).find("in voxels"), std::string::npos);
  EXPECT_THROW((void)request({"--quality", "best"}), CLI::ParseError);
}

TEST(SurfaceOptions, ParseEveryPartOfAThresholdMap) {
  const auto parsed =
      request({"--error", "4", "--unit", "world", "--region", "ball:1,2,3,4=0.5", "--region",
               "box:0,0,0,9,9,9=1", "--region-coordinates", "index", "--view",
               "eye=1,2,3,fov=45,height=600,pixels=0.5", "--combine", "minimum"});
  ASSERT_TRUE(parsed) << parsed.error().text;
  EXPECT_EQ(parsed->error, 4);
  EXPECT_EQ(parsed->unit, ErrorUnit::kWorld);
  const LocalThresholds& thresholds = parsed->thresholds;
  EXPECT_EQ(thresholds.coordinates, CoordinateSystem::kIndex);
  EXPECT_EQ(thresholds.combination, Combination::kMinimum);
  ASSERT_EQ(thresholds.regions.size(), 2U);
  EXPECT_EQ(thresholds.regions[0].threshold, 0.5);
  EXPECT_EQ(thresholds.regions[1].threshold, 1);
  EXPECT_EQ(thresholds.view.value().height_pixels, 600);
}

TEST(SurfaceOptions, ParseBudgetAndNormals) {
  const auto parsed = request({"--max-triangles", "50000", "--max-bytes", "1MB", "--normals", "9"});
  ASSERT_TRUE(parsed) << parsed.error().text;
  EXPECT_EQ(parsed->max_triangles, 50000U);
  EXPECT_EQ(parsed->max_bytes, 1U << 20);
  EXPECT_EQ(parsed->normal_bits, 9);
  EXPECT_NE(refusal({"--normals", "7"}).find("7 bits; they must have 8 to 10"), std::string::npos);
}

TEST(SurfaceOptions, RejectValuesOutOfRangeByRegionAndField) {
  EXPECT_NE(refusal({"--region", "ball:0,0,0,1=2", "--region", "ball:0,0,0,-1=2"})
                .find("regions[1].ball.radius is -1"),
            std::string::npos);
  EXPECT_NE(refusal({"--region", "ball:0,0,0,1=-2"}).find("regions[0].threshold is -2"),
            std::string::npos);
  EXPECT_NE(refusal({"--region", "halfspace:0,0,0,1=2"}).find("regions[0].half_space.normal"),
            std::string::npos);
  EXPECT_THROW((void)request({"--region", "box:0,0,0,1=2"}), CLI::ParseError);
  EXPECT_NE(
      refusal({"--view", "eye=0,0,0,fov=180,height=1,pixels=1"}).find("view.field_of_view is 180"),
      std::string::npos);
  EXPECT_THROW((void)request({"--combine", "maximum"}), CLI::ParseError);
  EXPECT_THROW((void)request({"--region-coordinates", "voxel"}), CLI::ParseError);
}

TEST(SurfaceOptions, ReadTheThresholdGrid) {
  const auto with = [](float threshold, std::vector<std::string> words) {
    Command command("", "test");
    SurfaceArguments arguments;
    arguments.threshold_files = {
        .formats = "A text file",
        .read = [threshold](const std::filesystem::path& file, double elsewhere,
                            const std::string&) -> Result<ThresholdGrid> {
          if (file != "grid.txt") {
            return fail(ErrorCode::kInvalidArgument, "Cannot read " + file.string());
          }
          return ThresholdGrid{.dims = {2, 1, 1},
                               .index_to_world = {},
                               .thresholds = {threshold, static_cast<float>(elsewhere)}};
        }};
    add_request_options(command, arguments, kRequested);
    EXPECT_NE(command.app().help("", CLI::AppFormatMode::All).find("A text file"),
              std::string::npos);
    std::reverse(words.begin(), words.end());
    command.app().parse(words);
    return request_of(arguments, info());
  };
  const auto parsed = with(0.5F, {"--threshold-grid", "grid.txt", "--error", "3"});
  ASSERT_TRUE(parsed) << parsed.error().text;
  EXPECT_EQ(parsed->thresholds.grid->thresholds, (std::vector<float>{0.5F, 3.0F}));
  EXPECT_EQ(with(1, {"--threshold-grid", "other"}).error().text, "Cannot read other");
  EXPECT_NE(
      with(-1, {"--threshold-grid", "grid.txt"}).error().text.find("grid.thresholds[0] is -1"),
      std::string::npos);
}

TEST(JsonReport, AlwaysSaysWhetherSurfacesAreSimplified) {
  EXPECT_EQ(json_of(IsosurfaceRequest{.simplify = true})["simplify"], true);
  EXPECT_EQ(json_of(IsosurfaceRequest{.simplify = false})["simplify"], false);
}

TEST(JsonReport, IncludesAnExistingThresholdMap) {
  EXPECT_FALSE(json_of(IsosurfaceRequest{}).contains("thresholds"));
  const auto parsed =
      request({"--region", "ball:1,2,3,4=0.5", "--region", "halfspace:1,0,0,4=1", "--view",
               "eye=1,2,3,fov=45,height=600,pixels=0.5,look=0,0,0,outside=8", "--max-bytes", "7"});
  ASSERT_TRUE(parsed) << parsed.error().text;
  const Json json = json_of(*parsed);
  EXPECT_EQ(json["max_bytes"], 7);
  const Json& map = json["thresholds"];
  EXPECT_EQ(map["region_coordinates"], "world");
  EXPECT_EQ(map["combine"], "order");
  EXPECT_EQ(map["regions"][0]["ball"]["radius"], 4);
  EXPECT_EQ(map["regions"][1]["halfspace"]["offset"], 4);
  EXPECT_EQ(map["regions"][1]["threshold"], 1);
  EXPECT_EQ(map["view"]["frustum"]["outside"], 8);
  EXPECT_FALSE(map.contains("grid"));
}

SurfaceArguments in_space(const std::string& space) {
  SurfaceArguments arguments;
  arguments.space = space;
  return arguments;
}

TEST(SurfaceOptions, ConvertTheMeshToTheRequestedSpace) {
  DatasetInfo patient = info();
  patient.index_to_world = {.columns = {Vec3{2, 0, 0}, Vec3{0, 0, 3}, Vec3{0, 4, 0}},
                            .translation = {10, 20, 30}};
  patient.meaning.space = WorldSpace::kLps;
  const Vec3 sample = {1, 1, 1};
  const auto placed = [&](const std::string& space) {
    const SurfaceArguments arguments = in_space(space);
    EXPECT_TRUE(request_of(arguments, patient));
    return output_map(arguments, patient)(sample);
  };
  EXPECT_EQ(placed("native"), (Vec3{12, 24, 33}));
  EXPECT_EQ(placed("lps"), placed("native"));
  EXPECT_EQ(placed("ras"), (Vec3{-12, -24, 33}));
  EXPECT_GT(output_map(in_space("ras"), patient).determinant() *
                output_map(in_space("lps"), patient).determinant(),
            0)
      << "turned, not mirrored";
  const LatticeMesh vertex{
      .vertices = {{32, 32, 32}}, .triangles = {}, .normals = {{0.6F, 0, 0.8F}}};
  const PositionedMesh turned = output_surface(vertex, in_space("ras"), patient).mesh;
  EXPECT_EQ(turned.positions[0], (Vec3{-12, -24, 33}));
  EXPECT_EQ(turned.normals[0], (UnitVector{-0.6F, 0, 0.8F}));
  EXPECT_EQ(output_surface(vertex, in_space("lps"), patient).mesh.normals[0], vertex.normals[0]);
  EXPECT_EQ(output_surface(vertex, in_space("lps"), patient).world.space, WorldSpace::kLps);
  EXPECT_EQ(output_surface(vertex, in_space("ras"), patient).world.space, WorldSpace::kRas);
  patient.meaning.space = WorldSpace::kRas;
  EXPECT_EQ(placed("lps"), (Vec3{-12, -24, 33}));
  SurfaceArguments indices = in_space("ras");
  indices.query.coordinates = CoordinateSystem::kIndex;
  EXPECT_FALSE(request_of(indices, patient));
  EXPECT_TRUE(request_of(in_space("native"), info()));
  const auto unknown = request_of(in_space("ras"), info());
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().text.find("does not define the directions"), std::string::npos);
}

TEST(SurfaceOptions, RemoveSmallComponentsOnlyOnRequest) {
  LatticeMesh mesh{.vertices = {}, .triangles = {}};
  for (const std::int32_t side : {1, 640, 2}) {  // Triangles far apart from each other.
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    const std::int32_t at = 1000 * static_cast<std::int32_t>(first + 1);
    mesh.vertices.insert(mesh.vertices.end(),
                         {{at, at, at}, {at + side, at, at}, {at, at + side, at}});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  const OutputSurface all = output_surface(mesh, {}, info());
  EXPECT_EQ(all.components, 3U);
  EXPECT_EQ(all.mesh.triangles.size(), 3U);
  EXPECT_EQ(all.large, (std::vector<std::uint32_t>{3, 4, 5}));
  EXPECT_EQ(removed_text(all), "");
  SurfaceArguments large;
  large.query.min_component = 10;
  const OutputSurface one = output_surface(mesh, large, info());
  EXPECT_EQ(one.mesh.triangles.size(), 1U);
  EXPECT_EQ(one.large, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(removed_text(one), "1 of 3 components, those with a diagonal of 10 samples or more");
  large.query.min_component = kLargestAlone;
  const OutputSurface largest = output_surface(mesh, large, info());
  EXPECT_EQ(largest.mesh.positions, one.mesh.positions);
  EXPECT_NEAR(largest.min_component, 20 * std::sqrt(2.0), 1e-12) << "a number for files";
  EXPECT_EQ(output_surface({.vertices = {}, .triangles = {}}, large, info()).components, 0U);
}

// Frames a picture without dust but with all large parts of a flow.
TEST(SurfaceOptions, CountComponentsAsLargeFromAnEighthOfTheLargest) {
  LatticeMesh mesh{.vertices = {}, .triangles = {}};
  for (const std::int32_t side : {79, 640, 81}) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    const std::int32_t at = 1000 * static_cast<std::int32_t>(first + 1);
    mesh.vertices.insert(mesh.vertices.end(),
                         {{at, at, at}, {at + side, at, at}, {at, at + side, at}});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  EXPECT_EQ(output_surface(mesh, {}, info()).large, (std::vector<std::uint32_t>{3, 4, 5, 6, 7, 8}));
  EXPECT_TRUE(output_surface({.vertices = {}, .triangles = {}}, {}, info()).large.empty());
}

}  // namespace
}  // namespace multitetra
