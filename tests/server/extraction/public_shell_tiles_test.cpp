// Sample shells of the public volumes, end to end: read, prepared, extracted as tiles from bricks
// and decoded, they equal what core's marching tetrahedra make of the file's samples, at several
// spacings, tile sizes and value forms, with isovalues between sample values and on them. The
// volumes are not part of the project. The large ones run when MULTITETRA_ALL_TESTS is set.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <vector>

#include "common/base/in_parallel.hpp"
#include "common/mesh/content_digest.hpp"
#include "common/wire/shell_tile.hpp"
#include "server/dataset/dataset.hpp"
#include "server/extraction/shell_extractor.hpp"
#include "server/volume/volume_files.hpp"
#include "tests/support/make_dataset.hpp"
#include "tests/support/public_volume_list.hpp"
#include "tests/support/sample_shells.hpp"
#include "tests/support/volume_in_memory.hpp"

namespace multitetra {
namespace {

using shell::ShellValues;
using testing::OwnedBox;
using testing::PublicVolume;

constexpr int kResolution = 5;
constexpr double kLayerValue = -7;  // The value outside the data where the surface is closed.

struct Sum {
  ContentDigest digest = {};
  std::size_t triangles = 0;
  void add(const Sum& other) {
    digest += other.digest;
    triangles += other.triangles;
  }
  friend bool operator==(const Sum&, const Sum&) = default;
};

template <typename PartOf>
Sum in_parts(std::size_t count, const PartOf& part_of) {
  std::vector<Sum> parts(count);
  in_parallel(count, [&](std::size_t i) { parts[i] = part_of(i); });
  Sum sum;
  for (const Sum& part : parts) sum.add(part);
  return sum;
}

// The surface of all tiles, decoded as by a client.
Sum of_tiles(const PreparedVolume& dataset, const ShellLevel& level, int max_cells) {
  const std::vector<EncodedTile> tiles = extract_shells(dataset, level, {}, max_cells);
  const ShellTileForm form = {.lattice_resolution = level.lattice_resolution,
                              .finest_spacing = level.finest_spacing,
                              .shell = level.shell};
  return in_parts(tiles.size(), [&](std::size_t i) -> Sum {
    const auto mesh = decode_shell_tile(*tiles[i].payload, tiles[i].summary, form);
    if (!mesh) throw std::runtime_error(mesh.error().text);
    return {digest(*mesh), mesh->triangles.size()};
  });
}

// The surface of the file's samples, tetrahedron by tetrahedron, quantized to `levels` levels per
// octave unless `levels` is 0.
Sum of_samples(const std::vector<OwnedBox>& boxes, double isovalue, std::int32_t spacing,
               int levels) {
  return in_parts(boxes.size(), [&](std::size_t i) {
    const OwnedBox& box = boxes[i];
    const auto value = [&](int x, int y, int z) {
      const auto sample = static_cast<double>(box.value(x, y, z));
      return levels == 0 ? sample : testing::quantized(sample, isovalue, levels);
    };
    const auto triangles =
        testing::marched(box, levels == 0 ? isovalue : 0, kResolution, spacing, value);
    Sum sum = {.triangles = triangles.size()};
    for (const LatticeTriangle& triangle : triangles) sum.digest += digest(triangle, kResolution);
    return sum;
  });
}

std::vector<ShellStep> modes_with(int levels) {
  if (levels > 0) return {quantized_shells(levels)};
  return {{.values = ShellValues::kExact}, {.values = ShellValues::kLatticeExact}};
}

class PublicShellTiles : public ::testing::TestWithParam<PublicVolume> {
 protected:
  void expect_marched(const PreparedVolume& dataset, const std::vector<OwnedBox>& boxes,
                      double isovalue, std::int32_t spacing, const std::vector<int>& all_levels) {
    for (const int levels : all_levels) {
      const Sum expected = of_samples(boxes, isovalue, spacing, levels);
      for (const ShellStep& shell : modes_with(levels)) {
        const ShellLevel level = {.isovalue = isovalue,
                                  .lattice_resolution = kResolution,
                                  .finest_spacing = spacing,
                                  .shell = shell};
        if (!has_shells(dataset.info, level)) continue;
        ++compared_;
        // The tile sizes alternate: testing both everywhere would take twice as long.
        const int cells = (compared_ + spacing) % 2 == 0 ? 16 : kShellCells;
        EXPECT_EQ(of_tiles(dataset, level, cells), expected)
            << "isovalue " << isovalue << ", spacing " << spacing << ", values "
            << static_cast<int>(shell.values) << ' ' << levels << ", " << cells << " cells";
      }
    }
  }

  int compared_ = 0;
};

TEST_P(PublicShellTiles, DecodeToTheMarchedSamplesOfTheFile) {
  const PublicVolume& chosen = GetParam();
  if (const auto why = testing::why_skipped(chosen)) GTEST_SKIP() << *why;
  const Volume volume =
      read_volume(std::filesystem::path(MULTITETRA_PUBLIC_DATA) / chosen.file, {.raw = chosen.raw});
  const double at = chosen.isovalues.front();
  const bool takes_all = std::getenv("MULTITETRA_ALL_TESTS") != nullptr;
  for (const bool is_closed : {false, true}) {
    SCOPED_TRACE(is_closed ? "closed" : "open");
    const std::optional<double> outside = is_closed ? std::optional(kLayerValue) : std::nullopt;
    const std::int32_t margin = is_closed ? 1 : 0;
    const DatasetPtr dataset =
        make_dataset(*source_of(volume), {.name = "volume", .outside = outside, .margin = margin});
    for (const std::int32_t spacing : {1, 2}) {
      const auto boxes = testing::boxes_of(volume, outside, margin, spacing, 64);
      const std::vector<int> levels =
          takes_all ? std::vector{0, 1, 2, 4, 8} : std::vector{0, is_closed ? 8 : 1};
      // Closed surfaces have isovalues on sample values, open ones between them.
      expect_marched(*dataset, boxes, is_closed ? at : at + 0.5, spacing, levels);
    }
  }
  EXPECT_GT(compared_, 0);
}

INSTANTIATE_TEST_SUITE_P(All, PublicShellTiles, ::testing::ValuesIn(testing::public_volumes()),
                         testing::name_of_volume);

}  // namespace
}  // namespace multitetra
