// The datasets that a server offers, by name. A catalogue is filled once, then shared read-only; a
// server changes its offer by replacing the catalogue.
//
// Descriptions are encoded when a dataset is added, so a list is made by copying bytes.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/natural_order.hpp"
#include "server/stream/surface_provider.hpp"

namespace multitetra {

// A dataset that is not served yet, because its volume is being read.
struct DatasetReading {
  std::string name;
  double share = 0;  // Of the volume, 0 to 1.
};
// Returns those at this moment. Callable from any thread.
using ReadingsSource = std::function<std::vector<DatasetReading>()>;

class DatasetCatalogue {
 public:
  struct Entry {
    std::shared_ptr<const SurfaceProvider> source;
    std::shared_ptr<const std::string> encoded;  // By encoded_dataset().
    std::string json;                            // One line, without the histogram.
  };
  using Entries = std::map<std::string, Entry, NaturalOrder>;

  // Null: no dataset is being read.
  explicit DatasetCatalogue(ReadingsSource readings = nullptr) : readings_(std::move(readings)) {}

  // Throws std::invalid_argument if a dataset of that name exists.
  void add(std::shared_ptr<const SurfaceProvider> source);

  // Returns null if no dataset has that name.
  [[nodiscard]] std::shared_ptr<const SurfaceProvider> find(std::string_view name) const;

  [[nodiscard]] const Entries& entries() const { return entries_; }  // In natural order of names.
  // Returns the datasets whose volumes are being read, which are none of the entries.
  [[nodiscard]] std::vector<DatasetReading> readings() const;
  [[nodiscard]] std::size_t size() const { return entries_.size(); }
  // Returns whether there are datasets, of which none gives this catalogue's clients samples.
  [[nodiscard]] bool is_for_surfaces_only() const { return size() > 0 && !has_samples_; }

 private:
  ReadingsSource readings_;
  Entries entries_;
  bool has_samples_ = false;
};

using CataloguePtr = std::shared_ptr<const DatasetCatalogue>;

}  // namespace multitetra
