#include "server/core/planning/refinement_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {
namespace {

// Sizes are estimates: what is aimed at stays below what is promised.
constexpr double kEstimateMargin = 0.85;
constexpr double kMaxFirstTriangles = 40'000;
// A final step that is made from so few comes as fast as a preview.
constexpr double kExtractedWithoutPreviews = 50'000;
constexpr std::int32_t kLeastStepsASide = 8;  // Of a preview's own grid.

StepRequest preview_at(const IsosurfaceRequest& request, std::int32_t finest,
                       const DatasetInfo& info) {
  const double unit = request.unit == LengthUnit::kVoxel ? 1.0 : voxel_length(info);
  StepRequest step{.request = request, .finest_spacing = finest};
  double& floor = step.request.thresholds.at_least;
  floor = std::min(std::max(floor, finest / 2.0 * unit), std::numeric_limits<double>::max());
  step.request.topology_tolerance = std::max(request.topology_tolerance, finest / 2.0);
  // Fine lattice steps are lost on coarse tetrahedra.
  step.request.lattice_resolution = std::min(request.lattice_resolution, finest >= 8 ? 3 : 4);
  return step;
}

bool is_worth_showing(std::int32_t finest, const DatasetInfo& info) {
  return (1 << info.grid_exponent) / finest >= kLeastStepsASide;
}

std::optional<StepRequest> first_preview(const IsosurfaceRequest& request, const DatasetInfo& info,
                                         const StepSizes& sizes) {
  const SurfaceSize final = sizes.rough(request);
  if (final.extracted < kExtractedWithoutPreviews) return std::nullopt;
  const double whole = std::max(final.bytes, kLeastWhole);
  std::optional<StepRequest> coarsest;
  for (std::int32_t finest = kSpectrumSpacing; is_worth_showing(finest, info); finest *= 2) {
    coarsest = preview_at(request, finest, info);
    const SurfaceSize size = sizes.of(*coarsest);
    if (size.triangles <= kMaxFirstTriangles && size.bytes <= kEstimateMargin * kFirstShare * whole)
      break;
  }
  return coarsest;
}

std::optional<StepRequest> second_preview(const IsosurfaceRequest& request, const ShownStep& first,
                                          const DatasetInfo& info, const StepSizes& sizes) {
  const double whole = std::max(sizes.of({.request = request}).bytes, kLeastWhole);
  const double left = kEstimateMargin * kPreviewsShare * whole - first.bytes;
  // From coarse to fine, while they fit. One that shows hardly more than the first is not worth its
  // bytes.
  double least = 2 * first.bytes;
  std::optional<StepRequest> best;
  for (std::int32_t finest = first.step.finest_spacing / 2; finest >= 2; finest /= 2) {
    if (2 * least > left) break;  // The next is at least twice as large as the one before.
    const StepRequest preview = preview_at(request, finest, info);
    const double bytes = sizes.of(preview).bytes;
    if (bytes > left) break;
    if (bytes > least) best = preview;
    least = std::max(least, bytes);
  }
  return best;
}

}  // namespace

NextStep next_step(const IsosurfaceRequest& request, bool previews,
                   std::span<const ShownStep> shown, const DatasetInfo& info,
                   const StepSizes& sizes) {
  std::optional<StepRequest> preview;
  if (previews && shown.empty()) preview = first_preview(request, info, sizes);
  if (previews && shown.size() == 1) preview = second_preview(request, shown[0], info, sizes);
  if (preview) return {.step = *preview, .is_final = false};
  return {.step = {.request = request, .finest_spacing = 1}, .is_final = true};
}

double estimated_bytes(double triangles, const StepRequest& step) {
  const int normal_bits = step.request.normal_bits;
  const double normals = normal_bits == 0 ? 0 : 0.6 + 0.15 * (normal_bits - kMinNormalBits);
  const double a_triangle =
      0.3 + 0.19 * (step.request.lattice_resolution + std::log2(step.finest_spacing)) + normals;
  return triangles * a_triangle + kBytesATile * std::ceil(triangles / kTrianglesATile);
}

}  // namespace multitetra
