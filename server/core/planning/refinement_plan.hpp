// The models that a progressive stream shows before the requested one, so that a useful preview is
// seen at once, and the final step soon.
//
// A preview ends the hierarchy at a *finest spacing* f: noise keeps most triangles of a model at
// any error while its topology is preserved, and a certified bound adds up along sharp borders, so
// it is f that makes a preview small, and a topology tolerance of f / 2 lets go what f cannot show.
// A preview is simplified only where the bytes that this saves on the link are worth the time.
// Steps are planned by time, of the server, on the link and of the client (CostEstimates):
//
//     first      f = 8, 16, 32, ...    the finest that is there within kFirstServerSeconds and
//                                      kFirstLinkSeconds and kFirstClientSeconds, and needs at most
//                                      kFirstFetchedBytes of what the server must fetch from a
//                                      store itself
//     next       at most half of f     the finest that takes no longer than all before, else the
//                                      next one if it takes at most kPatience times as long; none
//                                      where the final step is there within kSoonSeconds anyway
//     certified  f = 1                 the request's own model, where it is only simplification
//                                      that takes so long, or the full resolution in shells: it
//                                      keeps the same bound, in more triangles
//     final      f = 1                 the request itself, when another preview would delay it by
//                                      more than kPreviewShare of its own time, or the certified
//                                      one by more than kCertifiedShare: what it delays has nothing
//                                      new to show
//
// Where the client decodes sample shells, previews have these, which take a part of the time and
// the bytes; and where it keeps no mesh, the certified one is the final step unless the request
// itself is complete sooner.
//
// Previews also keep to the request's budget, as far as estimates go. The first one never reads
// samples that are finer than the spectrum. Which steps come depends on the machines and the link;
// the content of a step never does. So the steps of a stream are named (Preview), and a stream that
// continues elsewhere requests exactly those.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "common/request/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"
#include "common/request/preview.hpp"
#include "server/core/planning/cost_estimates.hpp"

namespace multitetra {

// One step of a stream: a request, and where its hierarchy ends.
struct StepRequest {
  IsosurfaceRequest request;
  std::int32_t finest_spacing =
      1;  // Grid steps, a power of two: no finer dividing point takes part.
  // The surface is that of the uniform level of the spacing, in sample shells; none: in meshes.
  std::optional<ShellStep> shell = {};

  friend bool operator==(const StepRequest&, const StepRequest&) = default;
};

[[nodiscard]] inline StepForm form_of(const StepRequest& step) {
  if (step.shell) return StepForm::kShells;
  if (!step.request.simplify) return StepForm::kPlain;
  return step.request.embedded ? StepForm::kEmbedded : StepForm::kSimplified;
}

// The request itself as a step.
[[nodiscard]] inline StepRequest final_step(const IsosurfaceRequest& request) {
  return {.request = request, .finest_spacing = request.cell ? request.cell->finest_spacing : 1};
}

// Where the plan learns how large a step would be. Both may be estimates.
struct SizeEstimates {
  // The size of any step; costs a small part of making it.
  std::function<SurfaceSize(const StepRequest&)> of;
  // The size of the request itself, from the spectrum alone; a lower estimate.
  std::function<SurfaceSize(const IsosurfaceRequest&)> rough;
  // The bytes to fetch from a remote store before the spectrum of that spacing and of coarser ones
  // can be looked at. Empty: none.
  std::function<std::uint64_t(std::int32_t finest)> to_fetch = {};
};

struct DeliveredStep {
  StepRequest step;
  SurfaceSize size = {};
  double seconds = 0;  // The server's, to make it.
};

struct PlannedStep {
  StepRequest step;
  bool is_final = false;
};

inline constexpr double kFirstServerSeconds = 0.05;
inline constexpr double kFirstLinkSeconds = 0.1;
inline constexpr double kFirstClientSeconds = 0.1;
inline constexpr std::uint64_t kFirstFetchedBytes = std::uint64_t{128} << 10;
inline constexpr double kPatience = 5;
inline constexpr double kPreviewShare = 0.2;
inline constexpr double kSoonSeconds = 0.3;
inline constexpr double kCertifiedShare = 0.5;
// More are not worth decoding and drawing for a moment.
inline constexpr double kMostCertifiedTriangles = 2.5e6;
// The most triangles of a certified step of shells, which is quickly made and decoded.
inline constexpr double kMostShellTriangles = 12e6;
// The levels an octave of previews, the fewest bytes: what they move, 0.29 of the spacing, is small
// beside what the spacing leaves out.
inline constexpr int kPreviewLevels = 1;

// Further inputs of a plan.
struct PlanLimits {
  bool previews = true;
  // For the certified preview; 0 disables it.
  double certified_triangles = kMostCertifiedTriangles;
  bool shells = false;      // The client decodes them.
  bool is_display = false;  // It keeps no mesh.
  // The most triangles of a final step of shells.
  double shell_triangles = kMostShellTriangles;
};

// The preview of a request that a Preview names.
[[nodiscard]] StepRequest preview_step(const IsosurfaceRequest& request, const Preview& preview,
                                       const DatasetInfo& info);

// The step after those that were shown, of which none is final: a preview or exactly `request`.
// The same arguments give the same step. Each step refines the one before.
[[nodiscard]] PlannedStep next_step(const IsosurfaceRequest& request, const PlanLimits& limits,
                                    std::span<const DeliveredStep> shown, const DatasetInfo& info,
                                    const SizeEstimates& sizes, const CostEstimates& costs);

// Whatever is in it; and what it has on average.
inline constexpr double kBytesATile = 250;
inline constexpr double kTrianglesATile = 10'000;

// Bits of a vertex in sample shells of spacing 1, as measured on public volumes. `type` is that
// of the dataset's samples: the more bits exact ones have, the more of these are noise.
[[nodiscard]] double bits_a_vertex(const ShellStep& shell, SampleType type, int lattice_resolution);

// Encoded bytes of a mesh of so many triangles, as measured on public volumes: about
// 1.3 bytes a triangle at the default resolution and 0.19 for every doubling of it; with normals of
// 8 bits 0.6 more, and 0.15 for every bit beyond. In sample shells bits_a_vertex().
[[nodiscard]] double estimated_bytes(double triangles, const StepRequest& step,
                                     SampleType type = SampleType::kU16);

}  // namespace multitetra
