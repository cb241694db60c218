// Machine-readable reports, as made by the library and written by the client program.
#include "client/library/report.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/base/number_text.hpp"
#include "common/json/json_report.hpp"
#include "tests/client/scripted_server.hpp"
#include "tests/support/octahedra.hpp"

namespace multitetra {
namespace {

using nlohmann::json;
using testing::ScriptedServer;
using testing::ThenTheServer;
using Messages = std::vector<ServerMessage>;

const IsosurfaceRequest kReportedRequest = {.isovalue = 100.5, .error = 1};

// Stream 2 with one final step: the octahedron in two tiles.
Messages octahedron_stream() {
  const auto tiles = testing::coarse_tiles();
  StepBegin begin{.request_id = 2,
                  .is_final = true,
                  .request = kReportedRequest,
                  .error_bound_world = 1,
                  .tetrahedra = 100,
                  .active_tetrahedra = 10,
                  .tiles = {}};
  StepEnd end{.request_id = 2, .tiles_sent = 2, .digest = {}, .seconds = 0.5};
  Messages stream;
  for (const EncodedTile& tile : tiles) {
    stream.push_back(Tile{2, 0, static_cast<std::uint32_t>(begin.tiles.size()), tile.payload});
    begin.tiles.push_back(tile.summary);
    end.digest += tile.summary.digest;
    end.payload_bytes += tile.payload->size();
  }
  stream.insert(stream.begin(), begin);
  stream.push_back(end);
  stream.push_back(StreamEnd{.request_id = 2, .steps = 1});
  return stream;
}

FetchReport octahedron_report() {
  FetchReport report{.server = {.host = "127.0.0.1"},
                     .open = {.request_id = 2, .dataset = "octahedra", .request = kReportedRequest},
                     .steps = {},
                     .surface = {.mesh_file = "octahedron.ply"}};
  Assembler assembler(testing::octahedra_info(), report.open);
  for (const ServerMessage& message : octahedron_stream()) {
    EXPECT_TRUE(assembler.receive(message));
  }
  report.steps = {{.step = assembler.shown(), .first_byte_seconds = 0.25, .seconds = 0.75}};
  return report;
}

TEST(Report, BoundsAVolumeByAreaTimesDistance) {
  FetchReport report = octahedron_report();
  report.surface.measures = SurfaceMeasures{.area = 12, .volume = 4.0};
  report.surface.distance_bound = 1.5;
  EXPECT_EQ(json(json_of(report)).at("volume_bound"), 18.0);
  report.surface.measures->volume = std::nullopt;
  EXPECT_TRUE(json(json_of(report)).at("volume_bound").is_null());
}

TEST(Report, ExplainsAMissingVolume) {
  FetchReport report = octahedron_report();
  EXPECT_TRUE(json(json_of(report)).at("volume_reason").is_null());
  report.surface.measures = SurfaceMeasures{.area = 12, .volume = 4.0};
  EXPECT_TRUE(json(json_of(report)).at("volume_reason").is_null());
  report.surface.measures->volume = std::nullopt;
  DatasetInfo info = testing::octahedra_info();
  info.outside.reset();
  report.surface.open_reason = open_reason(info);
  const std::string reason = json(json_of(report)).at("volume_reason");
  EXPECT_NE(reason.find("--pad-value VALUE --pad 1 closes it"), std::string::npos) << reason;
  info.outside = -1000;
  info.margin = 1;
  info.void_samples = 7;
  EXPECT_EQ(
      open_reason(info),
      "at void samples of the data (NaN, or missing: 7), which --pad-value does not fill; give "
      "them a value in the volume");
}

TEST(Report, CallsOnlyTheAreaOfTheFullResolutionExact) {
  FetchReport report = octahedron_report();
  EXPECT_TRUE(json(json_of(report)).at("is_full_resolution").is_null());
  report.surface.measures = SurfaceMeasures{.area = 12, .volume = 4.0};
  const auto is_exact_at = [&](double error, double topology_tolerance) {
    auto step = std::make_shared<CommittedStep>(*report.steps.back().step);
    step->begin.error_bound_world = error;
    step->begin.request.topology_tolerance = topology_tolerance;
    report.steps.back().step = step;
    return json(json_of(report)).at("is_full_resolution").get<bool>();
  };
  EXPECT_TRUE(is_exact_at(0, 0));
  EXPECT_FALSE(is_exact_at(0.25, 0));
  report.surface.measures->area = 1234.5;
  EXPECT_EQ(json(json_of(report)).at("area"), 1234.5) << "that of the file";
  EXPECT_TRUE(is_exact_at(0, 0));
  EXPECT_EQ(json(json_of(report)).at("area"), 1234.5);
  EXPECT_FALSE(is_exact_at(0, 2));
}

TEST(Report, BoundsNoVolumeWithoutABoundedDistance) {
  FetchReport report = octahedron_report();
  report.surface.measures = SurfaceMeasures{.area = 12, .volume = 4.0};
  EXPECT_TRUE(json(json_of(report)).at("volume_bound").is_null());
}

TEST(VolumeNotice, ExplainsHowToNarrowAWideBound) {
  const SurfaceMeasures measures{.area = 12, .volume = -4.0};
  EXPECT_TRUE(volume_notice(measures, 0.003).empty());
  const auto wide = volume_notice(measures, 0.11);
  ASSERT_EQ(wide.size(), 1U);
  EXPECT_TRUE(
      wide[0].starts_with("volume_bound is 33 % of the volume; to quote the volume use --error 0"))
      << wide[0];
  EXPECT_TRUE(volume_notice(measures, std::nullopt).empty());
  EXPECT_TRUE(volume_notice({.area = 12, .volume = std::nullopt}, 0.11).empty());
}

TEST(MeshDistanceBound, AddsALatticeStep) {
  DatasetInfo info = testing::octahedra_info();
  info.index_to_world.columns = {Vec3{2, 0, 0}, Vec3{0, 3, 0}, Vec3{0, 0, 6}};
  StepBegin begin = octahedron_report().steps.back().step->begin;
  begin.error_bound_world = 0.25;
  EXPECT_DOUBLE_EQ(mesh_distance_bound(begin, info).value(),
                   0.25 + 7 / std::exp2(begin.request.lattice_resolution))
      << "the diagonal of 2, 3 and 6 is 7";
  begin.request.topology_tolerance = 2;
  EXPECT_FALSE(mesh_distance_bound(begin, info));
  begin.shell = ShellStep{};
  EXPECT_TRUE(mesh_distance_bound(begin, info)) << "sample shells ignore the tolerance";
}

TEST(Report, ContainsTheCountOfSelfIntersectingTriangles) {
  FetchReport report = octahedron_report();
  EXPECT_TRUE(json(json_of(report)).at("self_intersecting_triangles").is_null());
  report.surface.written = WrittenMesh{.self_intersections = SelfIntersections{.triangles = 3}};
  EXPECT_EQ(json(json_of(report)).at("self_intersecting_triangles"), 3);
}

TEST(Report, ListsEveryStepInJson) {
  const FetchReport report = octahedron_report();
  const StepEnd& end = report.steps.front().step->end;
  const json read = json(json_of(report));
  EXPECT_EQ(read.at("dataset"), "octahedra");
  EXPECT_EQ(read.at("server"), "tcp://127.0.0.1:7410");
  EXPECT_EQ(read.at("mesh_file"), "octahedron.ply");
  EXPECT_EQ(read.at("parameters").at("isovalue"), 100.5);
  EXPECT_FALSE(read.contains("error"));
  ASSERT_EQ(read.at("steps").size(), 1U);
  const json expected = {{"step", 0},
                         {"final", true},
                         {"error_bound_world", 1.0},
                         {"finest_spacing", 1},
                         {"tetrahedra", 100},
                         {"active_tetrahedra", 10},
                         {"triangles", 8},
                         {"vertices", 6},
                         {"euler_characteristic", 2},
                         {"components", 1},
                         {"border_edges", 0},
                         {"open_edges", 0},
                         {"nonmanifold_edges", 0},
                         {"degenerate_triangles", 0},
                         {"tiles", 2},
                         {"tiles_received", 2},
                         {"bytes", end.payload_bytes},
                         {"first_byte_seconds", 0.25},
                         {"seconds", 0.75},
                         {"server_seconds", 0.5},
                         {"content_digest", end.digest.hex()}};
  for (const auto& [key, value] : expected.items()) {
    ASSERT_TRUE(read["steps"][0].contains(key)) << key;
    EXPECT_EQ(read["steps"][0][key], value) << key;
  }
  EXPECT_EQ(read["steps"][0].at("checks").size(), 6U);
}

TEST(Report, KeepsTheStepsAndTheReasonOfAFailedFetch) {
  FetchReport report = octahedron_report();
  report.surface.mesh_file.clear();
  report.error = Error{ErrorCode::kUnavailable, "The connection was lost."};
  const json read = json(json_of(report));
  EXPECT_EQ(read.at("error"),
            (json{{"code", "unavailable"}, {"text", "The connection was lost."}}));
  EXPECT_TRUE(read.at("mesh_file").is_null());
  EXPECT_EQ(read.at("steps").size(), 1U);
}

TEST(Report, MarksPreviewsInTables) {
  FetchReport report = octahedron_report();
  EXPECT_EQ(checks_table(report.steps).find("preview"), std::string::npos);
  CommittedStep preview = *report.steps.front().step;
  preview.begin.finest_spacing = 2;
  preview.begin.is_final = false;
  report.steps.push_back({.step = std::make_shared<const CommittedStep>(preview)});
  EXPECT_NE(checks_table(report.steps).find("preview"), std::string::npos);
}

TEST(Report, MarksFinalStepsWithoutTopologyGuaranteeInTables) {
  CommittedStep tolerant = *octahedron_report().steps.front().step;
  tolerant.begin.request.topology_tolerance = 2;
  const std::string table =
      checks_table({{.step = std::make_shared<const CommittedStep>(tolerant)}});
  EXPECT_EQ(table.find("preview"), std::string::npos);
  EXPECT_NE(table.find(" no\n"), std::string::npos) << table;
}

TEST(Report, ShowsTheAllowedErrorOfSteps) {
  CommittedStep step = *octahedron_report().steps.front().step;
  const auto line = [&step] {
    DatasetInfo info = testing::octahedra_info();
    info.spacing = {2, 2, 3};
    info.meaning.length_unit = "mm";
    return step_line({.step = std::make_shared<const CommittedStep>(step)}, info);
  };
  step.begin.request.error = 0.5;
  EXPECT_EQ(line().find("step 0 (final): "), 0U) << line();
  EXPECT_NE(line().find(": isovalue 100.5, error 0.5 voxels,"), std::string::npos) << line();
  step.begin.request.thresholds.error_floor = 4;
  EXPECT_NE(line().find(", error 4 voxels,"), std::string::npos) << line();
  step.begin.request.thresholds.regions = {{.shape = BallShape{}, .threshold = 9}};
  step.begin.error_bound_world = 9;
  EXPECT_NE(line().find(", errors up to 4.5 voxels (9 mm),"), std::string::npos) << line();
  step.begin.is_final = false;
  EXPECT_EQ(line().find("step 0 (unsimplified): "), 0U) << line();
}

TEST(Report, ShowsTheSpacingAndNoErrorOfPreviews) {
  CommittedStep step = *octahedron_report().steps.front().step;
  step.begin.is_final = false;
  step.begin.finest_spacing = 4;
  const std::string line =
      step_line({.step = std::make_shared<const CommittedStep>(step)}, testing::octahedra_info());
  EXPECT_EQ(line.find("step 0 (preview): isovalue 100.5, 1 in 4 samples per axis, "), 0U) << line;
  EXPECT_EQ(line.find("error"), std::string::npos) << line;
}

// ---- the program with failing servers

class ReportOfProgram : public ::testing::Test {
 protected:
  ReportOfProgram() { std::filesystem::create_directories(folder_); }
  ~ReportOfProgram() override { std::filesystem::remove_all(folder_); }

  // Runs `fetch` against a server that answers with these messages; returns the exit code.
  int fetch_from(const Messages& stream) {
    Messages messages = {Welcome{},
                         DatasetList{.request_id = 1, .datasets = {testing::octahedra_info()}}};
    messages.insert(messages.end(), stream.begin(), stream.end());
    const ScriptedServer server(testing::framed_messages(messages), ThenTheServer::kHangsUp);
    const std::string command = MULTITETRA_CLIENT_PROGRAM
                                " fetch --dataset octahedra --isovalue 100.5 --error 1 "
                                "--simplify off --quiet --retries 0 --server " +
                                to_string(server.endpoint()) + " -o " +
                                (folder_ / "mesh.ply").string() + " --report " +
                                (folder_ / "report.json").string() + " 2>/dev/null";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  [[nodiscard]] json report() const {
    std::ifstream file(folder_ / "report.json");
    return json::parse(file, nullptr, /*allow_exceptions=*/false);
  }

  std::filesystem::path folder_ = std::filesystem::temp_directory_path() /
                                  ("multitetra_report_test_" + std::to_string(::getpid()));
};

TEST(TextList, ShowsASeriesAsOneEntryAndItsMembersOnRequest) {
  std::vector<DatasetInfo> datasets;
  for (const double time : {0.0, 0.5, 1.0}) {
    datasets.push_back(testing::octahedra_info("flow.t" + std::to_string(datasets.size())));
    datasets.back().member = SeriesMember{.series = "flow", .field = "density", .time = time};
    datasets.back().max += 1000 * time;
  }
  datasets.push_back(testing::octahedra_info("head"));
  const std::string all = text_list(datasets);
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 3) << all;
  EXPECT_NE(all.find("3 datasets: 3 times, 1 field"), std::string::npos) << all;
  EXPECT_EQ(all.find("flow.t1"), std::string::npos) << all;
  EXPECT_NE(all.find(" to " + shortest_text(datasets[2].max)), std::string::npos) << all;
  EXPECT_NE(all.find("head"), std::string::npos) << all;
  const std::string members = text_list(datasets, "flow");
  EXPECT_NE(members.find("flow.t2"), std::string::npos) << members;
  EXPECT_EQ(members.find("head"), std::string::npos) << members;
  datasets[1].member->field = "pressure";
  EXPECT_NE(text_list(datasets).find("of several fields"), std::string::npos);
  EXPECT_EQ(text_list(datasets, "organs"), "No series is named \"organs\".\n");
}

TEST_F(ReportOfProgram, IsWrittenOnSuccess) {
  EXPECT_EQ(fetch_from(octahedron_stream()), 0);
  EXPECT_FALSE(report().contains("error"));
  EXPECT_EQ(report().at("mesh_file"), (folder_ / "mesh.ply").string());
}

TEST_F(ReportOfProgram, IsWrittenWhenACheckFails) {
  Messages stream = octahedron_stream();
  stream.erase(stream.begin() + 1);
  EXPECT_EQ(fetch_from(stream), 3);
  EXPECT_EQ(report().at("error").at("code"), "damaged_data");
  EXPECT_TRUE(report().at("steps").empty());
  EXPECT_TRUE(report().at("mesh_file").is_null());
}

TEST_F(ReportOfProgram, IsWrittenWhenTheConnectionIsLost) {
  Messages stream = octahedron_stream();
  stream.pop_back();
  EXPECT_EQ(fetch_from(stream), 1);
  EXPECT_EQ(report().at("error").at("code"), "unavailable");
  EXPECT_EQ(report().at("steps").size(), 1U);
}

}  // namespace
}  // namespace multitetra
