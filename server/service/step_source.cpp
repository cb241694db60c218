#include "server/service/step_source.hpp"

#include "server/service/surface_extractor.hpp"

namespace multitetra {

const DatasetInfo& ExtractedSteps::info() const { return extractor_->dataset().info; }

EncodedStep ExtractedSteps::make(const StepRequest& step, std::stop_token stop) const {
  const TiledSurface surface = extractor_->extract(step, stop);
  return {.tetrahedra = surface.tetrahedra,
          .active_tetrahedra = surface.active_tetrahedra,
          .tiles = encode_tiles(surface, stop)};
}

}  // namespace multitetra
