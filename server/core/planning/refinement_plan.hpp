// Which models a progressive stream shows on its way to the one that was asked for.
//
// A preview ends the hierarchy at a *finest spacing* f: noise keeps most triangles of a model at
// any error while its topology is preserved, and a certified bound adds up along sharp borders, so
// it is f that makes a preview small, and a topology tolerance of f / 2 lets go what f cannot show.
// How large the steps are decides which f are used:
//
//     step        bytes, of the final step's            chosen from
//     first       at most kFirstShare                   f = 8, 16, 32, ...  the finest that fits
//     between     with the first kPreviewsShare         f = 2, 4, ...       the finest that fits
//     final       all                                   the request itself
//
// A final step of less than kLeastWhole bytes counts as one of so many: simplification makes small
// ones that take their time. The first preview never looks at samples that are finer than the
// spectrum.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "common/request/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"

namespace multitetra {

// One step of a stream: a request, and where its hierarchy ends.
struct StepRequest {
  IsosurfaceRequest request;
  std::int32_t finest_spacing =
      1;  // Grid steps, a power of two: no finer dividing point takes part.

  friend bool operator==(const StepRequest&, const StepRequest&) = default;
};

struct SurfaceSize {
  double triangles = 0;
  double bytes = 0;      // Encoded.
  double extracted = 0;  // Triangles before simplification, which cost the time.
};

// Where the plan learns how large a step would be. Both may be estimates.
struct StepSizes {
  // Of any step; costs a small part of making it.
  std::function<SurfaceSize(const StepRequest&)> of;
  // Of the request itself, from the spectrum alone; rather too small than too large.
  std::function<SurfaceSize(const IsosurfaceRequest&)> rough;
};

struct ShownStep {
  StepRequest step;
  double bytes = 0;
};

struct NextStep {
  StepRequest step;
  bool is_final = false;
};

inline constexpr double kFirstShare = 0.05;
inline constexpr double kPreviewsShare = 0.25;
inline constexpr double kLeastWhole = 64'000;

// What follows the steps that were shown, of which none is final: a preview or exactly `request`.
// The same arguments give the same step. Each step refines the one before.
[[nodiscard]] NextStep next_step(const IsosurfaceRequest& request, bool previews,
                                 std::span<const ShownStep> shown, const DatasetInfo& info,
                                 const StepSizes& sizes);

// Whatever is in it; and what it has on average.
inline constexpr double kBytesATile = 250;
inline constexpr double kTrianglesATile = 10'000;

// What a mesh of so many triangles takes when it is encoded, as measured on public volumes: about
// 1.3 bytes a triangle at the default resolution and 0.19 for every doubling of it; with normals of
// 8 bits 0.6 more, and 0.15 for every bit beyond.
[[nodiscard]] double estimated_bytes(double triangles, const StepRequest& step);

}  // namespace multitetra
