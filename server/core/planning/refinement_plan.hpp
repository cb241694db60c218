// Plans the models that a progressive stream shows before the requested one, so that a useful
// preview appears at once and the final step soon.
//
// A preview ends the hierarchy at a *finest spacing* f. While topology is preserved, noise keeps
// most triangles of a model at any error, and certified bounds accumulate along sharp borders: so
// previews become small through f, with a topology tolerance of f / 2 to remove what f cannot
// resolve. A preview is simplified only if the bytes saved on the link are worth the time. Steps
// are planned by their time on the server, on the link and in the client (CostEstimates):
//
//     first      f = 8, 16, 32, ...    the finest that takes at most kFirstServerSeconds,
//                                      kFirstLinkSeconds and kFirstClientSeconds, and needs at most
//                                      kFirstFetchedBytes from the server's own remote store
//     next       at most half of f     the finest that takes no longer than all previous steps, or
//                                      else the next one if it takes at most kMaxStepGrowth times
//                                      as long; none if the final step takes at most
//                                      kShortStepSeconds
//     certified  f = 1                 if only simplification is slow: the request's own model, or
//                                      the full resolution in shells, with the same bound but more
//                                      triangles
//     final      f = 1                 the request itself, once another preview would delay it by
//                                      more than kPreviewShare of its own time, or the certified
//                                      one by more than kCertifiedShare
//
// If the client decodes sample shells, previews use them, which takes a fraction of the time and
// bytes. If it also keeps no mesh, the certified step is the final one, unless the request itself
// is complete sooner.
//
// Previews also stay within the request's budget, as estimated. The first one never reads samples
// finer than the spectrum. The choice of steps depends on machines and link, but the content of a
// step never does. So the steps of a stream have names (Preview), and a stream resumed on another
// server requests exactly those.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "common/dataset/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"
#include "common/request/preview.hpp"
#include "server/core/planning/cost_estimates.hpp"

namespace multitetra {

// One step of a stream: a request, and the finest spacing of its hierarchy.
struct StepRequest {
  IsosurfaceRequest request;
  // Grid steps, a power of two. No finer point is kept.
  std::int32_t finest_spacing = 1;
  // If set, the surface of the uniform level of this spacing, in sample shells; otherwise meshes.
  std::optional<ShellStep> shell = {};

  friend bool operator==(const StepRequest&, const StepRequest&) = default;
};

[[nodiscard]] inline StepForm form_of(const StepRequest& step) {
  if (step.shell) return StepForm::kShells;
  if (!step.request.simplify) return StepForm::kPlain;
  return step.request.intersection_free ? StepForm::kIntersectionFree : StepForm::kSimplified;
}

// Returns the request itself as a step.
[[nodiscard]] inline StepRequest final_step(const IsosurfaceRequest& request) {
  return {.request = request, .finest_spacing = request.cell ? request.cell->finest_spacing : 1};
}

// Sources of step sizes for the plan; they may be estimates.
struct SizeEstimates {
  // Returns the size of any step, at a fraction of the cost of building it.
  std::function<SurfaceSize(const StepRequest&)> of;
  // Returns a lower estimate of the size of the request itself, from the spectrum alone.
  std::function<SurfaceSize(const IsosurfaceRequest&)> rough;
  // Returns the bytes that must be fetched from a remote store to read the spectrum of that spacing
  // and coarser ones. Empty if there are none.
  std::function<std::uint64_t(std::int32_t finest)> to_fetch = {};
};

struct DeliveredStep {
  StepRequest step;
  SurfaceSize size = {};
  double seconds = 0;  // The server's time to build it.
};

struct PlannedStep {
  StepRequest step;
  bool is_final = false;
};

inline constexpr double kFirstServerSeconds = 0.05;
inline constexpr double kFirstLinkSeconds = 0.1;
inline constexpr double kFirstClientSeconds = 0.1;
inline constexpr std::uint64_t kFirstFetchedBytes = std::uint64_t{128} << 10;
inline constexpr double kMaxStepGrowth = 5;
inline constexpr double kPreviewShare = 0.2;
inline constexpr double kShortStepSeconds = 0.3;
inline constexpr double kCertifiedShare = 0.5;
// More triangles are not worth decoding and drawing for a moment.
inline constexpr double kMaxCertifiedTriangles = 2.5e6;
// Maximum triangles of a certified step of shells, which are fast to encode and decode, unless the
// client says what it can draw.
inline constexpr double kMaxShellTriangles = 12e6;
// Levels per octave of previews. One needs the fewest bytes: its displacement of 0.29 of the
// spacing is small compared to what the spacing itself omits.
inline constexpr int kPreviewLevels = 1;

// Further inputs of a plan.
struct PlanLimits {
  bool previews = true;
  // Maximum triangles of the certified preview; 0 disables it.
  double certified_triangles = kMaxCertifiedTriangles;
  // The client decodes shells.
  bool shells = false;
  // The client keeps no mesh.
  bool is_display = false;
  // Maximum triangles of a certified or final step of shells.
  double shell_triangles = kMaxShellTriangles;
};

// Returns the preview of a request that a Preview identifies.
[[nodiscard]] StepRequest preview_step(const IsosurfaceRequest& request, const Preview& preview,
                                       const DatasetInfo& info);

// Returns the step after the delivered ones, none of which is final: a preview or exactly
// `request`. The same arguments give the same step. Each step refines the previous one.
[[nodiscard]] PlannedStep next_step(const IsosurfaceRequest& request, const PlanLimits& limits,
                                    std::span<const DeliveredStep> delivered,
                                    const DatasetInfo& info, const SizeEstimates& sizes,
                                    const CostEstimates& costs);

// Bytes of a tile independent of its content, and the average triangles of a tile.
inline constexpr double kBytesPerTile = 250;
inline constexpr double kTrianglesPerTile = 10'000;

// Returns the bits per vertex in sample shells of spacing 1, as measured on public volumes. `type`
// is that of the dataset's samples: the more bits exact samples have, the more of these are noise.
[[nodiscard]] double bits_per_vertex(const ShellStep& shell, SampleType type,
                                     int lattice_resolution);

// Returns the encoded bytes of a mesh with this number of triangles, as measured on public volumes:
// about 1.3 bytes a triangle at the default resolution and 0.19 for every doubling of it; with
// normals of 8 bits 0.6 more, and 0.15 for every further bit. In sample shells bits_per_vertex().
[[nodiscard]] double estimated_bytes(double triangles, const StepRequest& step,
                                     SampleType type = SampleType::kU16);

}  // namespace multitetra
