// The steps of a request as meshes, made by the calling thread with all threads of this process:
// what a program needs that has no clients.
//
//   SurfaceSteps steps(provider, {.isovalue = 500.5, .error = 0.5}, StepPolicy::kProgressive);
//   while (auto step = steps.next()) show((*step)->counted.surface);
#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "common/base/result.hpp"
#include "common/request/isosurface_request.hpp"
#include "server/service/surface.hpp"
#include "server/stream/stream_plan.hpp"
#include "server/stream/surface_provider.hpp"

namespace multitetra {

// Returns the tiles of a step, for assembled().
[[nodiscard]] ReceivedSurface tiles_of(StepResult step, const DatasetInfo& info,
                                       std::optional<ScalarRange> range);

struct SurfaceStep {
  CountedSurface counted;
  bool is_final = false;
};

class SurfaceSteps {
 public:
  // Requires a validated request.
  SurfaceSteps(std::shared_ptr<const SurfaceProvider> source, IsosurfaceRequest request,
               StepPolicy steps);

  // Makes the next step, coarse first; nullopt after the final one. Fails with kLimitExceeded if no
  // surface fits a budget. Throws what the dataset throws, and Cancelled soon after `stop` is
  // triggered.
  [[nodiscard]] Result<std::optional<SurfaceStep>> next(const std::stop_token& stop = {});

 private:
  std::shared_ptr<const SurfaceProvider> source_;
  StreamState state_;
  bool is_over_ = false;
};

// Returns the final step. Fails and throws as SurfaceSteps::next() does.
[[nodiscard]] Result<CountedSurface> final_surface(std::shared_ptr<const SurfaceProvider> source,
                                                   const IsosurfaceRequest& request,
                                                   const std::stop_token& stop = {});

}  // namespace multitetra
