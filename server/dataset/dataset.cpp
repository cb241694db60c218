#include "server/dataset/dataset.hpp"

#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/dataset/byte_source.hpp"
#include "server/dataset/prepared_file.hpp"

namespace multitetra {
namespace {

[[noreturn]] void fail_on(const std::filesystem::path& file, const char* section,
                          const std::string& what) {
  throw DatasetFileError("'" + file.string() + "': Section \"" + section + "\": " + what +
                         " Prepare the dataset again.");
}

void check_size(const std::filesystem::path& file, const char* section,
                std::span<const std::byte> bytes, std::size_t needed) {
  if (bytes.size() == needed) return;
  fail_on(file, section,
          "it has " + std::to_string(bytes.size()) +
              " bytes, and the metadata's dims and type need " + std::to_string(needed) + ".");
}

IsovalueBins bins_of(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  std::vector<float> edges(bytes.size() / sizeof(float));
  if (bytes.size() % sizeof(float) != 0 || edges.size() > IsovalueBins::kMaxCount + 1 ||
      edges.size() == 1) {
    fail_on(file, "bins",
            "it has " + std::to_string(bytes.size()) + " bytes; it must have none, or 8 to " +
                std::to_string(sizeof(float) * (IsovalueBins::kMaxCount + 1)) + " in fours.");
  }
  std::memcpy(edges.data(), bytes.data(), bytes.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (!std::isfinite(edges[i]) || (i > 0 && edges[i] <= edges[i - 1])) {
      fail_on(file, "bins", "its edges are not finite numbers that increase.");
    }
  }
  return IsovalueBins(std::move(edges));
}

}  // namespace

DatasetPtr open_dataset(const std::filesystem::path& path) {
  const auto file = std::make_shared<const PreparedFile>(path);
  DatasetInfo info = file->info();
  info.content_id = file->content_id();
  const auto width = static_cast<std::size_t>(bytes_per_sample(info.type));
  check_size(path, "coarse", file->coarse(), width * coarse_extent(info).size());
  check_size(path, "ranges", file->ranges(), 2 * width * cell_extent(info).size());
  return std::make_shared<const PreparedVolume>(
      PreparedVolume{.info = info,
                     .samples = file->samples(),
                     .coarse = file->coarse(),
                     .ranges = file->ranges(),
                     .spectrum = {.layout = SpectrumLayout(info),
                                  .bins = bins_of(path, file->bins()),
                                  .voxel = static_cast<float>(voxel_length(info)),
                                  .bricks = file->spectrum()},
                     .owner = file,
                     .check = [file] { file->check(); }});
}

Volume whole_volume(const PreparedVolume& dataset) {
  const DatasetInfo& info = dataset.info;
  Volume volume{.dims = info.dims,
                .spacing = info.spacing,
                .index_to_world = info.index_to_world,
                .samples = {}};
  const BrickLayout layout(info.dims);
  visit_type(info.type, [&]<typename Sample>(const Sample*) {
    std::vector<Sample> samples(volume.size());
    for (std::size_t i = 0; i < layout.size(); ++i) {
      const GridCounts brick = layout.at(i);
      const GridCounts extent = layout.extent(brick);
      const KeptBytes bytes = dataset.samples->brick(i);
      const std::byte* from = bytes.data();
      const std::size_t row_bytes = static_cast<std::size_t>(extent[0]) * sizeof(Sample);
      for (std::int32_t z = 0; z < extent[2]; ++z) {
        for (std::int32_t y = 0; y < extent[1]; ++y, from += row_bytes) {
          std::memcpy(&samples[volume.index(layout.side() * brick[0], layout.side() * brick[1] + y,
                                            layout.side() * brick[2] + z)],
                      from, row_bytes);
        }
      }
    }
    volume.samples = std::move(samples);
  });
  return volume;
}

}  // namespace multitetra
