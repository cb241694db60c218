#include "server/dataset/dataset.hpp"

#include <cstring>
#include <utility>
#include <vector>

#include "server/dataset/prepared_file.hpp"
#include "server/dataset/small_sections.hpp"

namespace multitetra {

DatasetPtr open_dataset(const std::filesystem::path& path) {
  const auto file = std::make_shared<const PreparedFile>(path);
  DatasetInfo info = file->info();
  info.content_id = file->content_id();
  check_small_sections(path, info, file->coarse().size(), file->ranges().size());
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
