// Catalogues of datasets, and the digests that a server must send.
#pragma once

#include <initializer_list>
#include <memory>

#include "common/mesh/content_digest.hpp"
#include "server/extraction/surface_extractor.hpp"
#include "server/service/caching_surface_provider.hpp"
#include "server/service/dataset_catalogue.hpp"
#include "tests/support/make_dataset.hpp"

namespace multitetra::testing {

inline std::shared_ptr<DatasetCatalogue> catalogue_with(std::initializer_list<DatasetPtr> datasets,
                                                        std::shared_ptr<SurfaceCache> cache = {}) {
  auto catalogue = std::make_shared<DatasetCatalogue>();
  for (const DatasetPtr& dataset : datasets) {
    catalogue->add(std::make_shared<CachingSurfaceProvider>(
        std::make_shared<const SurfaceExtractor>(dataset), cache));
  }
  return catalogue;
}

// Returns the digest of a step with Draco tiles.
inline ContentDigest extracted_digest(const DatasetPtr& dataset, const StepRequest& step) {
  ContentDigest sum;
  for (const TileMesh& tile : SurfaceExtractor(dataset).extract(step).tiles) {
    sum += digest(tile.mesh);
  }
  return sum;
}

}  // namespace multitetra::testing
