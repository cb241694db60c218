// The datasets that a server offers, by name. A catalogue is filled once, then shared read-only; a
// server changes its offer by replacing the catalogue.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/natural_order.hpp"
#include "server/stream/surface_provider.hpp"

namespace multitetra {

class DatasetCatalogue {
 public:
  // Throws std::invalid_argument if a dataset of that name exists.
  void add(std::shared_ptr<const SurfaceProvider> source);

  // Returns null if no dataset has that name.
  [[nodiscard]] std::shared_ptr<const SurfaceProvider> find(std::string_view name) const;

  [[nodiscard]] std::vector<DatasetInfo> infos() const;  // In natural order of names.
  [[nodiscard]] std::size_t size() const { return sources_.size(); }
  // Returns whether there are datasets, of which none gives this catalogue's clients samples.
  [[nodiscard]] bool is_for_surfaces_only() const { return size() > 0 && !has_samples_; }

 private:
  std::map<std::string, std::shared_ptr<const SurfaceProvider>, NaturalOrder> sources_;
  bool has_samples_ = false;
};

using CataloguePtr = std::shared_ptr<const DatasetCatalogue>;

}  // namespace multitetra
