#include "server/service/dataset_catalogue.hpp"

#include <stdexcept>

namespace multitetra {

void DatasetCatalogue::add(std::shared_ptr<const SurfaceProvider> source) {
  const std::string name = source->info().name;
  has_samples_ = has_samples_ || source->sends_shells();
  if (!sources_.try_emplace(name, std::move(source)).second) {
    throw std::invalid_argument("Two datasets are named \"" + name +
                                "\"; the names of datasets must be unique.");
  }
}

std::shared_ptr<const SurfaceProvider> DatasetCatalogue::find(std::string_view name) const {
  const auto found = sources_.find(name);
  return found == sources_.end() ? nullptr : found->second;
}

std::vector<DatasetInfo> DatasetCatalogue::infos() const {
  std::vector<DatasetInfo> infos;
  infos.reserve(sources_.size());
  for (const auto& [name, source] : sources_) infos.push_back(source->info());
  return infos;
}

}  // namespace multitetra
