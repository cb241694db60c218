#include "server/extraction/shell_extractor.hpp"

#include <algorithm>
#include <bit>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "common/codec/shell_encoder.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/extraction/detail/level_samples.hpp"

namespace multitetra {
namespace {

// Working memory of a thread, about 3 MB, reused for all tiles.
struct ShellMemory {
  shell::ShellEncoder encoder;
  SampleArray samples;
};

ShellMemory& memory_of_thread() {
  thread_local ShellMemory memory;
  return memory;
}

class ShellTiles {
 public:
  ShellTiles(const PreparedVolume& volume, const ShellLevel& level, std::uint32_t max_triangles)
      : volume_(volume),
        level_(level),
        samples_(volume, level.isovalue, level.finest_spacing),
        max_triangles_(max_triangles) {}

  // Returns the cubes of `max_cells` cells a side that may contain a surface.
  [[nodiscard]] std::vector<OctreeCube> cubes(int max_cells) const {
    const DatasetInfo& info = volume_.info;
    const int exponent =
        std::min(info.grid_exponent, std::countr_zero(static_cast<unsigned>(max_cells)) +
                                         exponent_of(level_.finest_spacing));
    const GridPoint last = last_sample(info);
    // Surfaces that close beyond the data do so within one cell of it.
    const auto first_cube = [&](std::int32_t v) { return std::max(v - 1, 0) >> exponent; };
    const auto last_cube = [&](std::int32_t v) {
      return std::min(v, (1 << info.grid_exponent) - 1) >> exponent;
    };
    const std::int32_t first = first_cube(info.margin);
    std::vector<OctreeCube> cubes;
    for (std::int32_t x = first; x <= last_cube(last.x); ++x) {
      for (std::int32_t y = first; y <= last_cube(last.y); ++y) {
        for (std::int32_t z = first; z <= last_cube(last.z); ++z) {
          const OctreeCube cube = {exponent, x, y, z};
          if (samples_.may_be_crossed(cube)) cubes.push_back(cube);
        }
      }
    }
    return cubes;
  }

  void prefetch_bricks(const std::vector<OctreeCube>& cubes) const {
    if (level_.finest_spacing >= kSpectrumSpacing || !volume_.samples->is_remote()) return;
    std::vector<std::size_t> bricks;
    for (const OctreeCube& cube : cubes) {
      const auto box = level_box(volume_.info, cube, level_.finest_spacing);
      if (box) samples_.add_bricks(cube, *box, bricks);
    }
    std::sort(bricks.begin(), bricks.end());
    bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
    volume_.samples->prefetch(bricks);
  }

  // Appends the tiles of one cube: none, one, or several smaller ones.
  void add_tiles(const OctreeCube& cube, std::vector<EncodedTile>& tiles) const {
    const auto whole = level_box(volume_.info, cube, level_.finest_spacing);
    const auto box = whole ? samples_.crossed_part(cube, *whole) : std::nullopt;
    if (!box) return;
    const std::vector<std::uint8_t> bytes = encoded(cube, *box);
    shell::ShellHeader header;
    if (read_shell_header(bytes.data(), bytes.size(), header) != shell::ShellStatus::kOk) {
      throw std::logic_error("A sample shell that was just written cannot be read.");
    }
    if (header.triangles == 0) return;
    if (header.triangles > max_triangles_) {
      for (int i = 0; i < 8; ++i) {
        if (samples_.may_be_crossed(cube.child(i))) add_tiles(cube.child(i), tiles);
      }
      return;
    }
    auto payload = std::make_shared<const std::string>(bytes.begin(), bytes.end());
    tiles.push_back({.summary = {.cube = cube,
                                 .digest = digest_of_bytes(*payload),
                                 .triangles = header.triangles,
                                 .vertices = header.vertices,
                                 .bytes = static_cast<std::uint32_t>(payload->size())},
                     .payload = std::move(payload)});
  }

 private:
  [[nodiscard]] std::vector<std::uint8_t> encoded(const OctreeCube& cube,
                                                  const LevelBox& box) const {
    ShellMemory& memory = memory_of_thread();
    samples_.read(cube, box, memory.samples);
    const GridPoint origin = box.origin();
    shell::ShellBox coded{.samples = {},
                          .data_samples = {box.count.x, box.count.y, box.count.z},
                          .origin = {origin.x, origin.y, origin.z},
                          .layers = box.layers,
                          .layer_value = box.layers == 0 ? 0 : outside_value(volume_.info)};
    std::visit(
        [&]<typename Sample>(const std::vector<Sample>& samples) {
          coded.samples =
              shell::SampleBlock<Sample>{.first = samples.data(),
                                         .row = box.count.x,
                                         .slice = std::ptrdiff_t{box.count.x} * box.count.y};
        },
        memory.samples);
    auto bytes =
        memory.encoder.encode(coded, {.isovalue = level_.isovalue,
                                      .values = level_.shell.values,
                                      .levels_per_octave = level_.shell.levels_per_octave,
                                      .lattice_resolution = level_.lattice_resolution,
                                      .spacing_exponent = exponent_of(level_.finest_spacing)});
    if (!bytes) throw std::logic_error(to_string(cube) + ": " + bytes.error().text);
    return *std::move(bytes);
  }

  const PreparedVolume& volume_;
  const ShellLevel& level_;
  LevelSamples samples_;
  std::uint32_t max_triangles_;
};

}  // namespace

std::vector<EncodedTile> extract_shells(const PreparedVolume& volume, const ShellLevel& level,
                                        const std::stop_token& stop, int max_cells,
                                        std::uint32_t max_triangles) {
  const ShellTiles shells(volume, level, max_triangles);
  const std::vector<OctreeCube> cubes = shells.cubes(max_cells);
  shells.prefetch_bricks(cubes);
  std::vector<std::vector<EncodedTile>> parts(cubes.size());
  in_parallel(
      cubes.size(), [&](std::size_t i) { shells.add_tiles(cubes[i], parts[i]); }, stop);
  std::vector<EncodedTile> tiles;
  for (auto& part : parts) std::move(part.begin(), part.end(), std::back_inserter(tiles));
  std::sort(tiles.begin(), tiles.end(), [](const EncodedTile& a, const EncodedTile& b) {
    return a.summary.cube < b.summary.cube;
  });
  if (volume.check) volume.check();
  return tiles;
}

}  // namespace multitetra
