// Plans and builds the next step of a stream: the work of a server thread for a session.
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

// The state of a stream: everything that determines its next step.
struct StreamState {
  IsosurfaceRequest request = {};  // The received request.
  StepPolicy steps = StepPolicy::kProgressive;
  // The stream starts with these previews, regardless of the plan.
  std::vector<Preview> resumed_previews = {};
  std::vector<DeliveredStep> delivered = {};
  // The client's speed, or 0 if unknown.
  double triangles_per_second = 0;
  // The level of the budget's error schedule, once known.
  std::optional<int> level = {};
  // The client decodes shells and may receive them.
  bool shells = false;
  MeshUse use = MeshUse::kKeep;
  // The maximum triangles of a step of full-resolution shells; 0 for kMaxShellTriangles.
  std::uint64_t drawable_triangles = 0;
};

struct StepResult {
  StepRequest step = {};
  bool is_final = false;
  // Nothing was built: there are no more previews, and only previews were requested.
  bool is_over = false;
  EncodedStep encoded = {};
  // This step is not yet in `delivered`.
  StreamState after = {};
  // The scalars of each tile, if the stream has scalars.
  std::vector<ScalarsOfTile> scalars = {};
};

struct StepLimits {
  // Maximum triangles of a final step; 0 for no limit.
  std::uint64_t max_triangles = 0;
  // The bandwidth to the client.
  double bytes_per_second = kDefaultBytesPerSecond;
  // Other work waits for threads: skips the certified preview.
  bool is_contended = false;
  // Builds final steps as meshes (see SurfaceProvider::make_meshes).
  bool as_meshes = false;
};

// Plans and builds the next step. A final step with a budget is within it, and uses most of it or
// has the request's own error; it has at most `limits.max_triangles` triangles. Fails with
// kLimitExceeded if not even the coarsest surface is within the budget or, as soon as that is
// certain, if the final step would exceed max_triangles; the error text states its size or the
// error at which it would fit. Rethrows exceptions of the source; throws Cancelled soon after
// `stop` is triggered.
[[nodiscard]] Result<StepResult> make_next_step(const SurfaceProvider& source,
                                                const StreamState& state, std::stop_token stop,
                                                const StepLimits& limits = {});

// Estimates the size of the reply to a request, and the request as its budget allows it, from a
// sample (surface_sizes.hpp). Fails with kLimitExceeded if the coarsest one seems larger.
struct EstimatedAnswer {
  SurfaceSize size;
  IsosurfaceRequest request;
};
[[nodiscard]] Result<EstimatedAnswer> estimate(const SurfaceProvider& source,
                                               const IsosurfaceRequest& request,
                                               std::stop_token stop);

}  // namespace multitetra
