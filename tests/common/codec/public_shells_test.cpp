// Sample shells of the public volumes: their tiles decode to what core's marching tetrahedra make
// of the same samples, with isovalues between sample values and on them.
//
// The volumes are not part of the project. The large ones run when MULTITETRA_ALL_TESTS is set.

#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

#include "common/mesh/content_digest.hpp"
#include "server/volume/volume_files.hpp"
#include "tests/support/public_volume_list.hpp"
#include "tests/support/sample_shells.hpp"

namespace multitetra {
namespace {

using shell::ShellStatus;
using shell::ShellValues;
using testing::boxes_of;
using testing::decode_shell;
using testing::DecodedShell;
using testing::marched;
using testing::OwnedBox;
using testing::PublicVolume;

class PublicShells : public ::testing::TestWithParam<PublicVolume> {};

DecodedShell through_bytes(shell::ShellEncoder& encoder, const OwnedBox& box,
                           const shell::ShellOptions& options) {
  const auto bytes = encoder.encode(box.box(), options);
  if (!bytes) {
    ADD_FAILURE() << bytes.error().text;
    return {};
  }
  DecodedShell decoded = decode_shell(*bytes);
  EXPECT_EQ(decoded.status, ShellStatus::kOk);
  return decoded;
}

TEST_P(PublicShells, DecodeToTheMarchedSamples) {
  const PublicVolume& chosen = GetParam();
  if (const auto why = testing::why_skipped(chosen)) GTEST_SKIP() << *why;
  const Volume volume =
      read_volume(std::filesystem::path(MULTITETRA_PUBLIC_DATA) / chosen.file, {.raw = chosen.raw});
  const bool is_integer = volume.type() != SampleType::kF32;
  shell::ShellEncoder encoder;
  for (const double at : chosen.isovalues) {
    for (const double isovalue : {at, at + 0.5}) {
      SCOPED_TRACE(isovalue);
      for (const OwnedBox& box : boxes_of(volume, 0.0, 1, 1, 64)) {
        ContentDigest expected;
        const auto triangles = marched(box, isovalue, 5, 1, [&](int x, int y, int z) {
          return static_cast<double>(box.value(x, y, z));
        });
        for (const LatticeTriangle& triangle : triangles) expected += digest(triangle, 5);
        const auto expect_exact = [&](ShellValues values) {
          const LatticeMesh mesh =
              through_bytes(encoder, box, {.isovalue = isovalue, .values = values}).mesh;
          ASSERT_EQ(mesh.triangles.size(), triangles.size());
          ASSERT_EQ(digest(mesh), expected);
        };
        if (is_integer) expect_exact(ShellValues::kExact);
        expect_exact(ShellValues::kLatticeExact);
        for (const int levels : {1, 8}) {
          const LatticeMesh mesh = through_bytes(encoder, box,
                                                 {.isovalue = isovalue,
                                                  .values = ShellValues::kQuantized,
                                                  .levels_per_octave = levels})
                                       .mesh;
          ASSERT_EQ(mesh.triangles.size(), triangles.size());
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, PublicShells, ::testing::ValuesIn(testing::public_volumes()),
                         testing::name_of_volume);

}  // namespace
}  // namespace multitetra
