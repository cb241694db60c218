#include "server/service/surface_steps.hpp"

#include <chrono>
#include <limits>
#include <utility>

#include "server/core/thresholds/threshold_map.hpp"

namespace multitetra {

ReceivedSurface tiles_of(StepResult step, const DatasetInfo& info,
                         std::optional<ScalarRange> range) {
  ReceivedSurface tiles{.begin = {.request = step.step.request,
                                  .error_bound_world = largest_threshold(step.step.request, info),
                                  .finest_spacing = step.step.finest_spacing,
                                  .tetrahedra = step.encoded.tetrahedra,
                                  .active_tetrahedra = step.encoded.active_tetrahedra,
                                  .tiles = {},
                                  .crossed_octants = step.encoded.crossed_octants,
                                  .scalars = range},
                        .meshes = std::move(step.encoded.meshes)};
  for (const EncodedTile& tile : step.encoded.tiles) {
    tiles.begin.tiles.push_back(tile.summary);
    tiles.payloads.push_back(tile.payload);
    tiles.digest += tile.summary.digest;
  }
  for (const ScalarsOfTile& scalars : step.scalars) tiles.scalars.push_back(scalars.codes);
  return tiles;
}

SurfaceSteps::SurfaceSteps(std::shared_ptr<const SurfaceProvider> source, IsosurfaceRequest request,
                           StepPolicy steps)
    : source_(std::move(source)), state_{.request = std::move(request), .steps = steps} {}

Result<std::optional<SurfaceStep>> SurfaceSteps::next(const std::stop_token& stop) {
  if (is_over_) return std::nullopt;
  const auto start = std::chrono::steady_clock::now();
  auto made = make_next_step(
      *source_, state_, stop,
      {.bytes_per_second = std::numeric_limits<double>::infinity(), .as_meshes = true});
  if (!made) return tl::unexpected(made.error());
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  is_over_ = made->is_final;
  state_ = std::move(made->after);
  state_.delivered.push_back(
      {.step = made->step, .size = size_of(made->encoded), .seconds = seconds});
  auto counted = assembled_and_counted(tiles_of(*std::move(made), source_->info(), std::nullopt),
                                       source_->info(), stop);
  if (!counted) return tl::unexpected(counted.error());
  return SurfaceStep{.counted = *std::move(counted), .is_final = is_over_};
}

Result<CountedSurface> final_surface(std::shared_ptr<const SurfaceProvider> source,
                                     const IsosurfaceRequest& request,
                                     const std::stop_token& stop) {
  auto step = SurfaceSteps(std::move(source), request, StepPolicy::kFinalOnly).next(stop);
  if (!step) return tl::unexpected(step.error());
  return std::move((*step)->counted);
}

}  // namespace multitetra
