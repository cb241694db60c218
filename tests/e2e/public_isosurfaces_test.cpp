// The whole way on real data: every public volume is read, prepared, extracted and fetched over TCP
// at its isovalues. The topology is the same at every threshold, no mesh has a crack, and what
// arrives is what was extracted, for any number of threads.
//
// The volumes are not part of the project. The large ones take minutes and run when
// MULTITETRA_ALL_VOLUMES is set
// (`bash tests/run.sh --all`).

#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

#include <cstdlib>
#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "client/client.hpp"
#include "server/dataset/prepare.hpp"
#include "server/dataset/volume_files.hpp"
#include "server/service/surface_extractor.hpp"
#include "tests/service/running_server.hpp"

namespace multitetra {
namespace {

struct PublicVolume {
  std::string file;
  std::vector<double> isovalues;
  bool is_large = false;
  std::optional<RawLayout> raw = std::nullopt;
};

void PrintTo(const PublicVolume& volume, std::ostream* out) { *out << volume.file; }

RawLayout bytes(std::array<std::int32_t, 3> dims) { return {.dims = dims}; }
RawLayout shorts_behind_6_bytes(std::array<std::int32_t, 3> dims) {
  return {.dims = dims, .type = SampleType::kU16, .header_bytes = 6};
}

std::vector<PublicVolume> public_volumes() {
  return {
      {.file = "cthead/CThead.nhdr", .isovalues = {500, 1200}, .is_large = true},
      {.file = "head_128x128x112.dat",
       .isovalues = {500, 1200},
       .raw = shorts_behind_6_bytes({128, 128, 112})},
      {.file = "lobster_120x120x34.dat",
       .isovalues = {500, 1500},
       .raw = shorts_behind_6_bytes({120, 120, 34})},
      {.file = "fuel_64x64x64_uint8.raw", .isovalues = {15, 60, 140}, .raw = bytes({64, 64, 64})},
      {.file = "neghip_64x64x64_uint8.raw", .isovalues = {30, 80, 150}, .raw = bytes({64, 64, 64})},
      {.file = "Bucky_32x32x32_uint8.raw", .isovalues = {60, 120, 170}, .raw = bytes({32, 32, 32})},
      {.file = "tooth_103x94x161_uint8.raw", .isovalues = {100, 195}, .raw = bytes({103, 94, 161})},
      {.file = "tooth16/tooth.nhdr", .isovalues = {510, 1000}},
      {.file = "engine/engine.mhd", .isovalues = {70, 180}, .is_large = true},
      {.file = "bonsai_small/bonsai_small.mhd", .isovalues = {40, 110}, .is_large = true},
      {.file = "headsq/quarter.nhdr", .isovalues = {500, 1150}},
      {.file = "stent.nrrd", .isovalues = {0.15, 0.45}, .is_large = true},
      {.file = "hydrogen.vtk", .isovalues = {0.02, 0.1, 0.4}},
      {.file = "ironProt.vtk", .isovalues = {30, 80, 150}},
      {.file = "MRI-Head_256x256x256.nrrd", .isovalues = {50, 125}, .is_large = true},
      {.file = "Iguana.nii.gz", .isovalues = {40, 120}, .is_large = true},
      {.file = "chris_t1.nii.gz", .isovalues = {50, 105}, .is_large = true},
      {.file = "avg152T1_RL_nifti.nii.gz", .isovalues = {100, 175}},
      {.file = "frogtissue/frogtissue.mhd", .isovalues = {0.5}, .is_large = true},
      {.file = "HeadMRVolume/HeadMRVolume.mhd", .isovalues = {25, 65}},
      {.file = "Brain_float/Brain.mhd", .isovalues = {25, 60}},
      {.file = "visible_female_head_512x512x234_HU.nrrd",
       .isovalues = {-300, 300},
       .is_large = true},
  };
}

class PublicIsosurfaces : public ::testing::TestWithParam<PublicVolume> {};

// With everything computed anew by so many threads.
ContentDigest extracted_digest(const DatasetPtr& dataset, const StepRequest& step, int threads) {
  oneapi::tbb::task_arena arena(threads);
  ContentDigest sum;
  arena.execute([&] {
    for (const TileMesh& tile : SurfaceExtractor(dataset).extract(step).tiles)
      sum += digest(tile.mesh);
  });
  return sum;
}

TEST_P(PublicIsosurfaces, HaveOneTopologyNoCrackAndArriveAsExtracted) {
  const PublicVolume& volume = GetParam();
  const auto path = std::filesystem::path(MULTITETRA_PUBLIC_DATA) / volume.file;
  if (!std::filesystem::exists(path))
    GTEST_SKIP() << "NOT TESTED: there is no public volume " << volume.file;
  if (volume.is_large && std::getenv("MULTITETRA_ALL_VOLUMES") == nullptr) {
    GTEST_SKIP() << "NOT TESTED: " << volume.file
                 << " is large; `bash tests/run.sh --all` takes it too";
  }
  const DatasetPtr dataset = make_dataset(read_volume(path, {.raw = volume.raw}), "volume");
  const DatasetInfo& info = dataset->info;
  const auto catalogue = std::make_shared<DatasetCatalogue>();
  catalogue->add(
      std::make_shared<ExtractedSteps>(std::make_shared<const SurfaceExtractor>(dataset)));
  const testing::RunningServer server(catalogue);
  auto client = Client::connect(server.endpoint(), {.timeout = std::chrono::minutes(10)});
  ASSERT_TRUE(client) << client.error().error.text;

  for (const double isovalue : volume.isovalues) {
    std::optional<MeshTopology> full;
    for (const double error : {0.0, 0.5, 2.0}) {
      SCOPED_TRACE(::testing::Message() << "isovalue " << isovalue << ", error " << error);
      const IsosurfaceRequest request{.isovalue = isovalue, .error = error};
      // The client fails on an open or non-manifold edge in any step.
      const auto final_step = client->fetch(
          info, {.dataset = info.name, .request = request, .held = {}}, [](const FetchedStep&) {});
      ASSERT_TRUE(final_step) << final_step.error().error.text;
      const MeshTopology& topology = final_step->step->topology;
      EXPECT_GT(topology.triangles, 0);
      EXPECT_TRUE(topology.is_sound());
      if (!full) full = topology;
      EXPECT_EQ(topology.euler_characteristic, full->euler_characteristic);
      EXPECT_EQ(topology.components, full->components);
      EXPECT_LE(topology.triangles, full->triangles);
      for (const int threads : {1, 2, 4}) {
        EXPECT_EQ(extracted_digest(dataset, {.request = request}, threads),
                  final_step->step->end.digest)
            << threads << " threads";
      }
    }
  }
}

std::string test_name(const ::testing::TestParamInfo<PublicVolume>& parameter) {
  std::string name = parameter.param.file.substr(0, parameter.param.file.find_last_of('.'));
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return name;
}
INSTANTIATE_TEST_SUITE_P(All, PublicIsosurfaces, ::testing::ValuesIn(public_volumes()), test_name);

}  // namespace
}  // namespace multitetra
