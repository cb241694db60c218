// Reads, prepares, extracts and fetches over TCP every public volume at its isovalues. The topology
// is the same at every threshold, no mesh has a crack, and fetched and extracted meshes are equal,
// for any number of threads.
//
// The volumes are not part of the project. The large ones take minutes and run when
// MULTITETRA_ALL_TESTS is set (`bash tests/run.sh --all`).

#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

#include <filesystem>
#include <vector>

#include "client/library/client.hpp"
#include "server/volume/volume_files.hpp"
#include "tests/support/public_volume_list.hpp"
#include "tests/support/running_server.hpp"
#include "tests/support/served_datasets.hpp"

namespace multitetra {
namespace {

using testing::PublicVolume;

class PublicIsosurfaces : public ::testing::TestWithParam<PublicVolume> {};

// Extracts the step anew with the given number of threads.
ContentDigest extracted_digest(const DatasetPtr& dataset, const StepRequest& step, int threads) {
  oneapi::tbb::task_arena arena(threads);
  return arena.execute([&] { return testing::extracted_digest(dataset, step); });
}

TEST_P(PublicIsosurfaces, HaveOneTopologyNoCrackAndDecodeAsExtracted) {
  const PublicVolume& volume = GetParam();
  if (const auto why = testing::why_skipped(volume)) GTEST_SKIP() << *why;
  const auto path = std::filesystem::path(MULTITETRA_PUBLIC_DATA) / volume.file;
  const DatasetPtr dataset = make_dataset(read_volume(path, {.raw = volume.raw}), "volume");
  const DatasetInfo& info = dataset->info;
  const testing::RunningServer server(testing::catalogue_with({dataset}));
  auto client = Client::connect(server.endpoint(), {.timeout = std::chrono::minutes(10)});
  ASSERT_TRUE(client) << client.error().error.text;

  for (const double isovalue : volume.isovalues) {
    std::optional<MeshTopology> full;
    for (const auto& [error, simplify] : testing::tested_errors({0.0, 0.5, 2.0}, info)) {
      SCOPED_TRACE(::testing::Message() << "isovalue " << isovalue << ", error " << error
                                        << (simplify ? ", simplified" : ""));
      const IsosurfaceRequest request{.isovalue = isovalue, .error = error, .simplify = simplify};
      // The client fails on an open or non-manifold edge in any step.
      const auto final_step =
          client->fetch(info, {.dataset = info.name, .request = request, .cached_tile_digests = {}},
                        [](const FetchedStep&) {});
      ASSERT_TRUE(final_step) << final_step.error().error.text;
      const MeshTopology& topology = final_step->step->topology;
      EXPECT_GT(topology.triangles, 0);
      EXPECT_TRUE(topology.is_sound());
      if (!full) full = topology;
      EXPECT_EQ(topology.euler_characteristic, full->euler_characteristic);
      EXPECT_EQ(topology.components, full->components);
      EXPECT_LE(topology.triangles, full->triangles);
      // Simplification takes ten times as long.
      for (const int threads : simplify ? std::vector{1} : std::vector{1, 2, 4}) {
        EXPECT_EQ(extracted_digest(dataset, {.request = request}, threads),
                  final_step->step->end.digest)
            << threads << " threads";
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, PublicIsosurfaces, ::testing::ValuesIn(testing::public_volumes()),
                         testing::name_of_volume);

}  // namespace
}  // namespace multitetra
