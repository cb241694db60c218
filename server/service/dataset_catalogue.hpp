// The datasets that a server offers, by name. Filled once, then shared and only read: what changes
// is which catalogue a server offers.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "server/stream/surface_provider.hpp"

namespace multitetra {

class DatasetCatalogue {
 public:
  // Throws std::invalid_argument when a dataset of that name is there already.
  void add(std::shared_ptr<const SurfaceProvider> source);

  // Null when there is no dataset of that name.
  [[nodiscard]] std::shared_ptr<const SurfaceProvider> find(std::string_view name) const;

  [[nodiscard]] std::vector<DatasetInfo> infos() const;  // Sorted by name.
  [[nodiscard]] std::size_t size() const { return sources_.size(); }

 private:
  std::map<std::string, std::shared_ptr<const SurfaceProvider>, std::less<>> sources_;
};

using CataloguePtr = std::shared_ptr<const DatasetCatalogue>;

}  // namespace multitetra
