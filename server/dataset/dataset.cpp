#include "server/dataset/dataset.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "server/dataset/prepared_file.hpp"
#include "server/store/bucket.hpp"

namespace multitetra {
namespace {

constexpr const char* kSuffix = ".mtd";
// Maximum depth of the search in subfolders.
constexpr int kMaxDepth = 16;

IsovalueBins bins_of(const std::string& place, std::span<const std::byte> bytes) {
  const auto fail_with = [&](const std::string& what) {
    throw DatasetFileError(place, "Section \"bins\": " + what + " Prepare the dataset again.");
  };
  std::vector<float> edges(bytes.size() / sizeof(float));
  if (bytes.size() % sizeof(float) != 0 || edges.size() > IsovalueBins::kMaxCount + 1 ||
      edges.size() == 1) {
    fail_with("it has " + std::to_string(bytes.size()) + " bytes; it must have 0, or 8 to " +
              std::to_string(sizeof(float) * (IsovalueBins::kMaxCount + 1)) + ", a multiple of 4.");
  }
  if (!edges.empty()) std::memcpy(edges.data(), bytes.data(), bytes.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (!std::isfinite(edges[i]) || (i > 0 && edges[i] <= edges[i - 1])) {
      fail_with("its edges are not finite, increasing numbers.");
    }
  }
  return IsovalueBins(std::move(edges));
}

}  // namespace

DatasetPtr open_dataset(const std::string& place, std::shared_ptr<RemoteFiles> files) {
  if (is_address(place) && place.ends_with('/')) {
    throw StoreError(place, "HTTP servers do not list folders",
                     "Name each file, or a folder of a bucket (s3://)");
  }
  return dataset_in(PreparedFile(place, std::move(files)), place);
}

DatasetPtr dataset_in(const PreparedFile& opened, const std::string& place) {
  const auto file = std::make_shared<const PreparedFile>(opened);
  DatasetInfo info = file->info();
  info.content_id = file->content_id();
  return std::make_shared<const PreparedVolume>(
      PreparedVolume{.info = info,
                     .samples = file->samples(),
                     .coarse = LazyBytes([file] { return file->coarse(); }),
                     .ranges = LazyBytes([file] { return file->ranges(); }),
                     .spectrum = {.layout = SpectrumLayout(info),
                                  .bins = bins_of(place, file->bins()),
                                  .voxel = static_cast<float>(voxel_length(info)),
                                  .bricks = file->spectrum()},
                     .owner = file,
                     .check = [file] { file->check(); }});
}

bool is_folder_of_datasets(const std::string& place) {
  std::error_code ignored;
  return is_address(place) ? is_bucket_folder(place, kSuffix)
                           : std::filesystem::is_directory(place, ignored);
}

std::vector<std::string> datasets_in(const std::string& folder) {
  if (is_address(folder)) return list_bucket(folder, kSuffix);
  std::vector<std::string> found;
  (void)std::filesystem::directory_iterator(folder);  // Throws if the folder cannot be read.
  std::filesystem::recursive_directory_iterator at(
      folder, std::filesystem::directory_options::skip_permission_denied);
  for (const std::filesystem::recursive_directory_iterator end; at != end; ++at) {
    const std::filesystem::path& path = at->path();
    std::error_code ignored;
    if (at->is_directory(ignored)) {
      const bool is_left_out = path.filename().string().starts_with('.');
      if (is_left_out || at.depth() == kMaxDepth) at.disable_recursion_pending();
    } else if (path.extension() == kSuffix) {
      found.push_back(path.string());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
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
      const RetainedBytes bytes = dataset.samples->brick(i);
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
