#include "server/service/dataset_catalogue.hpp"

#include <stdexcept>
#include <utility>

#include "common/base/json.hpp"
#include "common/json/json_report.hpp"
#include "common/wire/messages.hpp"

namespace multitetra {
namespace {

std::string listed_json(const DatasetInfo& info) {
  Json json = json_of(info);
  json.erase("histogram");
  return json_text(json, -1);
}

}  // namespace

void DatasetCatalogue::add(std::shared_ptr<const SurfaceProvider> source) {
  const DatasetInfo& info = source->info();
  has_samples_ = has_samples_ || source->sends_shells();
  const auto [place, is_new] = entries_.try_emplace(info.name);
  if (!is_new) {
    throw std::invalid_argument("Two datasets are named \"" + info.name +
                                "\"; the names of datasets must be unique.");
  }
  place->second = {.source = source,
                   .encoded = std::make_shared<const std::string>(encoded_dataset(info)),
                   .json = listed_json(info)};
}

std::vector<DatasetReading> DatasetCatalogue::readings() const {
  if (!readings_) return {};
  std::vector<DatasetReading> readings = readings_();
  std::erase_if(readings, [&](const DatasetReading& one) { return entries_.contains(one.name); });
  return readings;
}

std::shared_ptr<const SurfaceProvider> DatasetCatalogue::find(std::string_view name) const {
  const auto found = entries_.find(name);
  return found == entries_.end() ? nullptr : found->second.source;
}

}  // namespace multitetra
