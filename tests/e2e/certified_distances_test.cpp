// Checks the certified bound on real data: no surface of bound `certified` is farther from the
// full-resolution one than its error plus the lattice's, both ways, and its topology is the same.
// Meshes are fetched over TCP and compared with the volume's file.
//
// The large volumes take minutes and run when MULTITETRA_ALL_TESTS is set (`bash tests/run.sh
// --all`).
#include <gtest/gtest.h>

#include <iostream>
#include <span>
#include <vector>

#include "client/library/client.hpp"
#include "server/certify/certificate.hpp"
#include "server/volume/generators/written_nrrd.hpp"
#include "tests/support/public_volume_list.hpp"
#include "tests/support/running_server.hpp"
#include "tests/support/served_datasets.hpp"
#include "tests/support/sweep.hpp"
#include "tests/support/triangle_meshes.hpp"

namespace multitetra {
namespace {

using testing::PublicVolume;

class CertifiedDistances : public ::testing::TestWithParam<PublicVolume> {};

TEST_P(CertifiedDistances, NeverExceedErrorPlusLattice) {
  const PublicVolume& volume = GetParam();
  if (const auto why = testing::why_skipped(volume)) GTEST_SKIP() << *why;
  const auto path = std::filesystem::path(MULTITETRA_PUBLIC_DATA) / volume.file;
  const Volume source = read_volume(path, {.raw = volume.raw});
  const DatasetPtr dataset = make_dataset(source, "volume");
  const testing::RunningServer server(testing::catalogue_with({dataset}));
  auto client = Client::connect(server.endpoint(), {.timeout = std::chrono::minutes(10)});
  ASSERT_TRUE(client) << client.error().error.text;
  const auto datasets = client->list_datasets();
  ASSERT_TRUE(datasets) << datasets.error().error.text;
  const DatasetInfo& info = datasets->front();

  const auto fetch = [&](const IsosurfaceRequest& request) {
    return client->fetch(info,
                         {.dataset = info.name,
                          .request = request,
                          .steps = StepPolicy::kFinalOnly,
                          .cached_tile_digests = {}},
                         [](const FetchedStep&) {});
  };
  // By default the first isovalue only.
  const std::size_t isovalues = testing::sweep<std::size_t>(1, volume.isovalues.size());
  for (const double isovalue : std::span(volume.isovalues).first(isovalues)) {
    const auto full = fetch({.isovalue = isovalue, .error = 0});
    ASSERT_TRUE(full) << full.error().error.text;
    const std::vector<double> errors = testing::sweep<std::vector<double>>({0.5, 2}, {0.5, 1, 2});
    for (const auto& [error, simplify] : testing::tested_errors(errors, info)) {
      SCOPED_TRACE(::testing::Message() << "isovalue " << isovalue << ", error " << error
                                        << (simplify ? ", simplified" : ""));
      const IsosurfaceRequest request{.isovalue = isovalue, .error = error, .simplify = simplify};
      const auto fetched = fetch(request);
      ASSERT_TRUE(fetched) << fetched.error().error.text;
      const Certificate certificate = certify(testing::in_world(fetched->step->mesh, info), source,
                                              {.isovalue = isovalue,
                                               .error = error * voxel_length(info),
                                               .lattice = kDefaultLatticeResolution,
                                               .samples = 20'000});
      EXPECT_TRUE(certificate.keeps_topology());
      EXPECT_EQ(certificate.mesh, fetched->step->topology);
      // At error 0, points with error 0 are fused: fewer triangles, the same surface.
      EXPECT_GE(certificate.reference.triangles, full->step->topology.triangles);
      EXPECT_EQ(certificate.reference.euler_characteristic,
                full->step->topology.euler_characteristic);
      EXPECT_EQ(certificate.reference.components, full->step->topology.components);
      const auto& [there, back] = certificate.distance;
      EXPECT_NE(certificate.error, ErrorVerdict::kExceeded)
          << there.maximum << " and " << back.maximum << " at (" << back.farthest[0] << ", "
          << back.farthest[1] << ", " << back.farthest[2] << ")";
      const double voxel = voxel_length(info);
      std::cout << volume.file << " isovalue " << isovalue << " error " << error
                << (simplify ? " simplified" : "") << ": maximum " << there.maximum / voxel
                << " and " << back.maximum / voxel << ", at most "
                << certificate.maximum_at_most() / voxel << ", 99 % " << there.percentile_99 / voxel
                << " and " << back.percentile_99 / voxel << " voxels" << std::endl;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, CertifiedDistances, ::testing::ValuesIn(testing::public_volumes()),
                         testing::name_of_volume);

}  // namespace
}  // namespace multitetra
