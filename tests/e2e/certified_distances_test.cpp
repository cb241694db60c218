// The promise on real data: no surface of bound `certified` is farther from the full-resolution one
// than its error and the lattice, both ways, and its topology is the same. The mesh comes over TCP,
// the volume through the client's own reader, the full surface from the client's own definition.
//
// The large volumes take minutes and run when MULTITETRA_ALL_VOLUMES is set
// (`bash tests/run.sh --all`).
#include <gtest/gtest.h>

#include <iostream>

#include "client/client.hpp"
#include "client/distance_check.hpp"
#include "client/local_volume.hpp"
#include "server/dataset/prepare.hpp"
#include "server/dataset/written_nrrd.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/service/extracted_surfaces.hpp"
#include "tests/support/public_volume_list.hpp"
#include "tests/support/running_server.hpp"
#include "tests/support/temporary_folder.hpp"

namespace multitetra {
namespace {

using testing::PublicVolume;

// Two headers are written in a way that ITK refuses and only the server repairs. The slices of one
// are raw files; the other is written again.
std::vector<float> local_copy(const PublicVolume& volume, const DatasetInfo& info) {
  const auto path = std::filesystem::path(MULTITETRA_PUBLIC_DATA) / volume.file;
  const TemporaryFolder folder;
  if (volume.file == "stent.nrrd") {
    write_nrrd(folder.path() / "stent.nrrd", read_volume(path));
    return read_local_volume(folder.path() / "stent.nrrd", info);
  }
  if (volume.file != "headsq/quarter.nhdr") return read_local_volume(path, info);
  std::string bytes;
  for (int slice = 1; slice <= info.dims[2]; ++slice) {
    bytes += bytes_of_file(path.parent_path() / ("quarter." + std::to_string(slice)));
  }
  return read_local_volume(folder.file("quarter.raw", bytes), info);
}

class CertifiedDistances : public ::testing::TestWithParam<PublicVolume> {};

TEST_P(CertifiedDistances, AreNeverAboveTheErrorAndTheLattice) {
  const PublicVolume& volume = GetParam();
  if (const auto why = testing::why_skipped(volume)) GTEST_SKIP() << *why;
  const auto path = std::filesystem::path(MULTITETRA_PUBLIC_DATA) / volume.file;
  const DatasetPtr dataset = make_dataset(read_volume(path, {.raw = volume.raw}), "volume");
  const auto catalogue = std::make_shared<DatasetCatalogue>();
  catalogue->add(
      std::make_shared<ExtractedSurfaces>(std::make_shared<const SurfaceExtractor>(dataset)));
  const testing::RunningServer server(catalogue);
  auto client = Client::connect(server.endpoint(), {.timeout = std::chrono::minutes(10)});
  ASSERT_TRUE(client) << client.error().error.text;
  const auto datasets = client->list_datasets();
  ASSERT_TRUE(datasets) << datasets.error().error.text;
  const DatasetInfo& info = datasets->front();
  const std::vector<float> samples = local_copy(volume, info);

  const auto fetch = [&](const IsosurfaceRequest& request) {
    return client->fetch(
        info,
        {.dataset = info.name, .request = request, .steps = StepPolicy::kFinalOnly, .held = {}},
        [](const FetchedStep&) {});
  };
  for (const double isovalue : volume.isovalues) {
    const auto full = fetch({.isovalue = isovalue, .error = 0});
    ASSERT_TRUE(full) << full.error().error.text;
    for (const auto& [error, simplify] : testing::tested_errors({0.5, 1.0, 2.0}, info)) {
      SCOPED_TRACE(::testing::Message() << "isovalue " << isovalue << ", error " << error
                                        << (simplify ? ", simplified" : ""));
      const IsosurfaceRequest request{.isovalue = isovalue, .error = error, .simplify = simplify};
      const auto fetched = fetch(request);
      ASSERT_TRUE(fetched) << fetched.error().error.text;
      const MeshTopology& topology = fetched->step->topology;
      EXPECT_TRUE(topology.is_sound());
      EXPECT_EQ(topology.euler_characteristic, full->step->topology.euler_characteristic);
      EXPECT_EQ(topology.components, full->step->topology.components);
      const DistanceCheck check =
          check_distances(*fetched->step, info, samples, {.samples = 20'000});
      ASSERT_TRUE(check.promise);
      for (const DistanceStatistics* way : {&check.mesh_to_full, &check.full_to_mesh}) {
        EXPECT_EQ(way->samples, 20'000U);
        EXPECT_EQ(way->above_limit, 0U)
            << way->worst_distance << " voxels, allowed " << way->worst_limit << ", at ("
            << way->worst_place[0] << ", " << way->worst_place[1] << ", " << way->worst_place[2]
            << ")";
      }
      std::cout << volume.file << " isovalue " << isovalue << " error " << error
                << (simplify ? " simplified" : "") << ": maximum " << check.mesh_to_full.maximum
                << " and " << check.full_to_mesh.maximum << ", 99 % "
                << check.mesh_to_full.percentile_99 << " and " << check.full_to_mesh.percentile_99
                << " voxels" << std::endl;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, CertifiedDistances, ::testing::ValuesIn(testing::public_volumes()),
                         testing::name_of_volume);

}  // namespace
}  // namespace multitetra
