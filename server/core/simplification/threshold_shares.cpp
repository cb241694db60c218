#include "server/core/simplification/threshold_shares.hpp"

#include <memory>

namespace multitetra {
IsosurfaceRequest model_request(const IsosurfaceRequest& request) {
  if (!request.simplify) return request;
  IsosurfaceRequest model = request;
  LocalThresholds& local = model.thresholds;
  model.error *= kModelShare;
  local.error_floor *= kModelShare;
  for (ThresholdRegion& region : local.regions) region.threshold *= kModelShare;
  if (local.grid) {
    ThresholdGrid grid = *local.grid;
    for (float& threshold : grid.thresholds) threshold *= static_cast<float>(kModelShare);
    local.grid = std::make_shared<const ThresholdGrid>(std::move(grid));
  }
  if (local.view) {
    local.view->tolerance_pixels *= kModelShare;
    if (local.view->frustum) local.view->frustum->outside *= kModelShare;
  }
  return model;
}

}  // namespace multitetra
