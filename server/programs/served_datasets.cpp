#include "server/programs/served_datasets.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <set>
#include <utility>

#include "server/dataset/objects/manifest.hpp"
#include "server/dataset/objects/object_dataset.hpp"
#include "server/operations/log.hpp"
#include "server/service/extracted_surfaces.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

std::string size_text(const DatasetInfo& info) {
  return std::to_string(info.dims[0]) + " x " + std::to_string(info.dims[1]) + " x " +
         std::to_string(info.dims[2]) + " " + std::string(name(info.type));
}

}  // namespace

ServedDatasets::ServedDatasets(const std::vector<std::string>& inputs,
                               std::shared_ptr<SurfaceCache> cache,
                               std::shared_ptr<ObjectCache> objects)
    : cache_(std::move(cache)),
      objects_(std::move(objects)),
      pool_(std::make_shared<CubeMemoryPool>()) {
  for (const std::string& input : inputs) {
    inputs_.push_back({input, is_folder_of_datasets(input)});
  }
}

ServedDatasets::Identity ServedDatasets::identity_of(const fs::path& file) const {
  if (is_address(file.string())) {
    try {
      const auto text = text_of(*objects_->place(file.string()).store, kManifestName);
      return {.manifest = text.value_or("")};
    } catch (const StoreError&) {
      return {};  // Opening it will tell.
    }
  }
  const fs::path told = is_object_dataset(file.string()) ? file / kManifestName : file;
  struct stat status {};
  if (::stat(told.c_str(), &status) != 0) return {};
  return {.device = status.st_dev,
          .inode = status.st_ino,
          .size = status.st_size,
          .modified = std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec};
}

// Each once, those of a folder by name.
std::vector<fs::path> ServedDatasets::files() const {
  std::vector<fs::path> files;
  for (const auto& [input, is_folder] : inputs_) {
    if (!is_folder) {
      files.push_back(input);
      continue;
    }
    const std::vector<fs::path> found = datasets_in(input);
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

std::shared_ptr<const SurfaceProvider> ServedDatasets::source_of(const fs::path& file) {
  const auto before = opened_.find(file);
  const Identity identity = identity_of(file);
  if (before != opened_.end() && before->second.identity == identity) return before->second.source;
  try {
    const DatasetPtr dataset = open_any_dataset(file.string(), objects_);
    const auto source = std::make_shared<ExtractedSurfaces>(
        std::make_shared<SurfaceExtractor>(dataset, pool_), cache_);
    opened_.insert_or_assign(file, Opened{identity, source});
    log_line(LogLevel::kInfo, "serving",
             {{"dataset", dataset->info.name},
              {"file", file.string()},
              {"size", size_text(dataset->info)}});
    return source;
  } catch (const std::exception& error) {
    const bool was_served = before != opened_.end();
    log_line(
        LogLevel::kError,
        std::string(was_served ? "what was there before goes on being served: " : "left out: ") +
            error.what(),
        {{"file", file.string()}});
    return was_served ? before->second.source : nullptr;
  }
}

CataloguePtr ServedDatasets::read() {
  auto catalogue = std::make_shared<DatasetCatalogue>();
  std::set<fs::path> there;
  for (const fs::path& file : files()) {
    if (!there.insert(file).second) continue;
    const auto source = source_of(file);
    if (!source) continue;
    try {
      catalogue->add(source);
    } catch (const std::invalid_argument& twice) {
      log_line(LogLevel::kError, std::string("left out: ") + twice.what(),
               {{"file", file.string()}});
    }
  }
  std::erase_if(opened_, [&](const auto& opened) {
    const auto& [file, what] = opened;
    if (there.contains(file)) return false;
    log_line(LogLevel::kInfo, "no longer served",
             {{"dataset", what.source->info().name}, {"file", file.string()}});
    return true;
  });
  return catalogue;
}

}  // namespace multitetra
