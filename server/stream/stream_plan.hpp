// The next step of a stream, decided and made: what a worker does for a session.
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "common/request/isosurface_request.hpp"
#include "common/wire/messages.hpp"
#include "server/core/planning/refinement_plan.hpp"
#include "server/stream/step_scalars.hpp"
#include "server/stream/surface_provider.hpp"

namespace multitetra {

// The state of a stream: all that its next step depends on.
struct StreamState {
  IsosurfaceRequest request = {};  // As it was made.
  StepPolicy steps = StepPolicy::kProgressive;
  // The stream starts with these previews, regardless of the plan.
  std::vector<Preview> resumed_previews = {};
  std::vector<DeliveredStep> shown = {};
  // The client's speed; 0: unknown.
  double triangles_per_second = 0;
  // The level of the budget's error schedule, once it is known.
  std::optional<int> level = {};
  bool shells = false;  // The client decodes them, and may.
  MeshUse use = MeshUse::kKeep;
};

struct StepResult {
  StepRequest step = {};
  bool is_final = false;
  // Nothing was made: of previews alone there are no more.
  bool is_over = false;
  TiledStep encoded = {};
  StreamState after = {};  // Without this step among those that were shown.
  // For the tiles, where the stream has scalars.
  std::vector<ScalarsOfTile> scalars = {};
};

struct StepLimits {
  // The most triangles of a final step; 0: no limit.
  std::uint64_t max_triangles = 0;
  // The bandwidth to the client.
  double bytes_per_second = kUsualBytesPerSecond;
  bool others_wait = false;  // For the threads: nothing is made that only comes sooner.
  // Make a final step as meshes (see SurfaceProvider::make_meshes).
  bool as_meshes = false;
};

// A final step with a budget is within it, and has most of it or the request's own error; and it
// has at most `limits.max_triangles`.
// kLimitExceeded when not even the coarsest surface is within the budget, or, as soon as that is
// sure, when the final step would have more triangles than that: the text says how large it is, or
// at which error it would fit. Throws what the source throws; Cancelled soon after `stop` is
// triggered.
[[nodiscard]] Result<StepResult> make_next_step(const SurfaceProvider& source,
                                                const StreamState& state, std::stop_token stop,
                                                const StepLimits& limits = {});

// Estimates the size of the reply to a request, and the request as its budget allows it: from a
// sample (surface_sizes.hpp). kLimitExceeded when the coarsest surface seems to be larger.
struct EstimatedAnswer {
  SurfaceSize size;
  IsosurfaceRequest request;
};
[[nodiscard]] Result<EstimatedAnswer> estimate(const SurfaceProvider& source,
                                               const IsosurfaceRequest& request,
                                               std::stop_token stop);

}  // namespace multitetra
