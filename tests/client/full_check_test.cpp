// `fetch --check full`, with the local volume in every form that it may have.
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/local_volume.hpp"
#include "server/dataset/prepare.hpp"
#include "server/dataset/written_nrrd.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/service/extracted_surfaces.hpp"
#include "tests/support/fake_steps.hpp"
#include "tests/support/fields.hpp"
#include "tests/support/running_server.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

namespace fields = testing::fields;
using nlohmann::json;
using testing::RunningServer;

std::string complaint_of(const std::filesystem::path& file, const DatasetInfo& info) {
  try {
    (void)read_local_volume(file, info);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "none";
}

template <typename Sample>
std::string bytes_of(const Volume& volume, bool turn_around = false) {
  std::string bytes;
  for (const Sample sample : std::get<std::vector<Sample>>(volume.samples)) {
    std::string one(reinterpret_cast<const char*>(&sample), sizeof(Sample));
    if (turn_around) std::reverse(one.begin(), one.end());
    bytes += one;
  }
  return bytes;
}

TEST(LocalVolume, IsReadAsTheServerReadsIt) {
  const TemporaryFolder folder;
  Volume volume = fields::noise({7, 5, 6}, 3, {1, 2, 0.5});
  std::get<std::vector<float>>(volume.samples)[11] = std::numeric_limits<float>::quiet_NaN();
  const auto path = folder.path() / "noise.nrrd";
  write_nrrd(path, volume);
  const auto read = read_local_volume(path, make_dataset(volume, "noise")->info);
  const auto& samples = std::get<std::vector<float>>(volume.samples);
  ASSERT_EQ(read.size(), samples.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_TRUE(read[i] == samples[i] || (i == 11 && read[i] != read[i])) << i;
  }
}

TEST(LocalVolume, OfRawBytesNeedsNoHeaderAndNoByteOrder) {
  const TemporaryFolder folder;
  const Volume volume = fields::sampled<std::uint16_t>(
      {7, 5, 6}, [](int x, int y, int z) { return 3 * x + 100 * y + 1000 * z; });
  const DatasetInfo info = make_dataset(volume, "steps")->info;
  const auto wanted =
      read_local_volume(folder.file("little.raw", bytes_of<std::uint16_t>(volume)), info);
  EXPECT_EQ(wanted[1], 3.0F);
  EXPECT_EQ(read_local_volume(folder.file("big.raw", bytes_of<std::uint16_t>(volume, true)), info),
            wanted);
  EXPECT_EQ(read_local_volume(folder.file("header.dat", "header" + bytes_of<std::uint16_t>(volume)),
                              info),
            wanted);
}

TEST(LocalVolume, ThatIsNotTheDatasetsIsRefusedWithTheDifference) {
  const TemporaryFolder folder;
  const Volume volume = fields::noise({7, 5, 6}, 3, {1, 2, 0.5});
  const DatasetInfo info = make_dataset(volume, "noise")->info;
  const auto written = [&](const std::string& name, const Volume& other) {
    write_nrrd(folder.path() / name, other);
    return folder.path() / name;
  };
  const auto says = [&](const std::filesystem::path& file, const std::string& words) {
    const std::string complaint = complaint_of(file, info);
    EXPECT_NE(complaint.find(words), std::string::npos) << complaint;
    EXPECT_NE(complaint.find(file.string()), std::string::npos) << complaint;
  };
  says(written("dims.nrrd", fields::noise({7, 6, 6}, 3, {1, 2, 0.5})), "7 x 6 x 6 samples");
  says(written("spacing.nrrd", fields::noise({7, 5, 6}, 3, {1, 2, 0.75})), "1 x 2 x 0.75");
  says(written("values.nrrd", fields::noise({7, 5, 6}, 4, {1, 2, 0.5})), "its values are from");
  says(folder.path() / "missing.nrrd", "no such file");
  says(folder.file("short.raw", "abc"), "it has 3 bytes");
  says(folder.file("other.raw", std::string(840, 'x')), "its values are from");
  says(folder.file("damaged.nrrd", "NRRD0004\nwhat?"), "damaged.nrrd");
}

// ---- the program

class FullCheck : public ::testing::Test {
 protected:
  int fetch(const RunningServer& server, const std::string& options) {
    const std::string command = MULTITETRA_CLIENT_PROGRAM " fetch --quiet --server " +
                                to_string(server.endpoint()) + " -o " +
                                (folder_.path() / "mesh.ply").string() + " --report " +
                                (folder_.path() / "report.json").string() + " " + options + " 2>" +
                                (folder_.path() / "complaints").string();
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  [[nodiscard]] json report() const {
    return json::parse(std::ifstream(folder_.path() / "report.json"));
  }
  [[nodiscard]] bool has_mesh() const {
    return std::filesystem::exists(folder_.path() / "mesh.ply");
  }

  TemporaryFolder folder_;
};

TEST_F(FullCheck, OfAnHonestServerPassesAndTellsTheDistances) {
  const Volume volume = fields::gyroid(25, 0.1, 3);
  write_nrrd(folder_.path() / "gyroid.nrrd", volume);
  auto catalogue = std::make_shared<DatasetCatalogue>();
  catalogue->add(std::make_shared<ExtractedSurfaces>(
      std::make_shared<const SurfaceExtractor>(make_dataset(volume, "gyroid"))));
  const RunningServer server(catalogue);
  const std::string against = "--against " + (folder_.path() / "gyroid.nrrd").string();
  ASSERT_EQ(fetch(server, "--dataset gyroid --isovalue 0.1 --error 0.5 --check full " + against +
                              " --samples 3000"),
            0);
  EXPECT_TRUE(has_mesh());
  const json distances = report().at("distances");
  EXPECT_EQ(distances.at("passed"), true);
  EXPECT_EQ(distances.at("threshold"), 0.5);
  for (const char* way : {"mesh_to_full", "full_to_mesh"}) {
    EXPECT_EQ(distances.at(way).at("samples"), 3000);
    EXPECT_GT(distances.at(way).at("maximum"), 0.01);
    EXPECT_LE(distances.at(way).at("maximum"), distances.at("limit"));
    EXPECT_LE(distances.at(way).at("mean"), distances.at(way).at("percentile_99"));
  }
  EXPECT_EQ(fetch(server, "--dataset gyroid --isovalue 0.1 --bound paper --check full " + against),
            0);
  EXPECT_TRUE(report().at("distances").at("passed").is_null());
  EXPECT_EQ(fetch(server, "--dataset gyroid --check full"), 2);
  EXPECT_EQ(fetch(server, "--dataset gyroid " + against), 2);
}

// An octahedron is served where the volume has a ball of another size.
TEST_F(FullCheck, OfAWrongSurfaceFailsAndWritesNoMesh) {
  const RunningServer server(
      testing::catalogue_of(std::make_shared<testing::FakeSteps>("octahedra")));
  std::string bytes(65 * 65 * 65, '\0');
  for (int i = 0; i < 27; ++i) {
    bytes[static_cast<std::size_t>(16 + i % 3 + 65 * (8 + i / 3 % 3) + 65 * 65 * (8 + i / 9))] =
        '\xff';
  }
  const std::string options =
      "--dataset octahedra --isovalue 100.5 --final-only --check full --against " +
      folder_.file("ball.raw", bytes).string();
  EXPECT_EQ(fetch(server, options), 3) << bytes_of_file(folder_.path() / "complaints");
  EXPECT_FALSE(has_mesh());
  EXPECT_EQ(report().at("distances").at("passed"), false);
  EXPECT_EQ(report().at("error").at("code"), "damaged_data");
  EXPECT_NE(bytes_of_file(folder_.path() / "complaints").find("a check failed: The mesh is"),
            std::string::npos);
}

}  // namespace
}  // namespace multitetra
