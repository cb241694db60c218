#include "server/programs/serving/served_datasets.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include "common/base/address_text.hpp"
#include "common/base/number_text.hpp"
#include "server/dataset/dataset.hpp"
#include "server/operations/log.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "server/store/store_error.hpp"

namespace multitetra {
namespace {

std::string size_text(const DatasetInfo& info) {
  return sides_text(info.dims) + " " + std::string(name(info.type));
}

}  // namespace

ServedDatasets::ServedDatasets(const std::vector<std::string>& inputs,
                               std::shared_ptr<SurfaceCache> cache,
                               std::shared_ptr<RemoteFiles> files, ReadingsSource readings)
    : cache_(std::move(cache)),
      files_(std::move(files)),
      readings_(std::move(readings)),
      pool_(std::make_shared<CubeMemoryPool>()) {
  for (const std::string& input : inputs) {
    inputs_.push_back({input, is_folder_of_datasets(input)});
  }
}

ServedDatasets::Identity ServedDatasets::identity_of(const std::string& place) const {
  if (is_address(place)) {
    try {
      return {.version = files_->version_of(place)};
    } catch (const StoreError&) {
      return {};  // Opening it reports the reason.
    }
  }
  struct stat status {};
  if (::stat(place.c_str(), &status) != 0) return {};
  return {.device = status.st_dev,
          .inode = status.st_ino,
          .size = status.st_size,
          .modified = std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec};
}

// Returns all dataset paths without repetition, those of a folder sorted by name.
std::vector<std::string> ServedDatasets::dataset_paths() const {
  std::vector<std::string> paths;
  for (const auto& [input, is_folder] : inputs_) {
    if (!is_folder) {
      paths.push_back(input);
      continue;
    }
    const std::vector<std::string> found = datasets_in(input);
    paths.insert(paths.end(), found.begin(), found.end());
  }
  return paths;
}

ServedDatasets::Opened* ServedDatasets::opened(const std::string& place) {
  const auto before = opened_.find(place);
  const Identity identity = identity_of(place);
  if (before != opened_.end() && before->second.identity == identity) return &before->second;
  try {
    const DatasetPtr dataset = open_dataset(place, files_);
    const auto source = std::make_shared<CachingSurfaceProvider>(
        std::make_shared<SurfaceExtractor>(dataset, pool_), cache_);
    return &opened_.insert_or_assign(place, Opened{identity, source}).first->second;
  } catch (const std::exception& error) {
    const bool was_served = before != opened_.end();
    log_line(LogLevel::kError,
             std::string(was_served ? "still serving the previous version: " : "skipped: ") +
                 error.what(),
             {{"file", without_password(place)}});
    is_complete_ = false;
    is_store_failing_ |= dynamic_cast<const StoreError*>(&error) != nullptr;
    return was_served ? &before->second : nullptr;
  }
}

CataloguePtr ServedDatasets::read() {
  auto catalogue = std::make_shared<DatasetCatalogue>(readings_);
  std::set<std::string> names;
  const std::vector<std::string> paths = dataset_paths();
  if (paths.empty() && !opened_.empty()) {
    throw std::runtime_error(
        "All datasets are gone. Is a folder no longer mounted? To serve none, stop the server.");
  }
  is_complete_ = true;
  is_store_failing_ = false;
  std::map<std::string, std::size_t> new_members;  // Per series.
  for (const std::string& place : paths) {
    if (!names.insert(place).second) continue;
    Opened* const found = opened(place);
    if (found == nullptr) continue;
    try {
      catalogue->add(found->source);
      if (std::exchange(found->is_served, true)) continue;
      const DatasetInfo& info = found->source->info();
      if (info.member) {
        ++new_members[info.member->series];
        continue;
      }
      log_line(
          LogLevel::kInfo, "serving",
          {{"dataset", info.name}, {"file", without_password(place)}, {"size", size_text(info)}});
    } catch (const std::invalid_argument& twice) {
      found->is_served = false;
      is_complete_ = false;
      log_line(LogLevel::kError, std::string("skipped: ") + twice.what(),
               {{"file", without_password(place)}});
    }
  }
  if (catalogue->size() == 0 &&
      std::ranges::any_of(opened_, [](const auto& one) { return one.second.is_served; })) {
    throw std::runtime_error(
        "All datasets are gone, and none of the new ones can be read. To serve none, stop the "
        "server.");
  }
  for (const auto& [series, members] : new_members) {
    log_line(LogLevel::kInfo, "serving",
             {{"series", series}, {"datasets", std::uint64_t{members}}});
  }
  std::erase_if(opened_, [&](const auto& one) {
    const auto& [place, what] = one;
    if (names.contains(place)) return false;
    if (what.is_served) {
      log_line(LogLevel::kInfo, "no longer served",
               {{"dataset", what.source->info().name}, {"file", without_password(place)}});
    }
    return true;
  });
  return catalogue;
}

}  // namespace multitetra
