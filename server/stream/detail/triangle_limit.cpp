#include "server/stream/detail/triangle_limit.hpp"

#include <algorithm>
#include <utility>

#include "common/base/number_text.hpp"

namespace multitetra {
namespace {

// Returns the factor by which a quick estimate may exceed the actual size (see SizeAccuracy).
double quick_limit_factor(const IsosurfaceRequest& request) { return request.simplify ? 3 : 1.6; }

}  // namespace

TriangleLimit::TriangleLimit(const SurfaceProvider& source, std::uint64_t max_triangles,
                             std::stop_token stop)
    : source_(source), max_triangles_(max_triangles), stop_(std::move(stop)) {}

Result<void> TriangleLimit::check_estimate(const IsosurfaceRequest& request,
                                           const SizeEstimates& sizes) const {
  if (max_triangles_ == 0 || request.max_bytes > 0) return {};
  if (request.max_triangles > 0 && request.max_triangles <= max_triangles_) return {};
  if (sizes.rough(request).triangles <= max_triangles()) return {};
  const double triangles = sizes.of({.request = request}).triangles;
  if (triangles <= quick_limit_factor(request) * max_triangles()) return {};
  return fail(ErrorCode::kLimitExceeded, limit_error_text("about ", triangles, request, 1));
}

Result<void> TriangleLimit::check_made(const IsosurfaceRequest& request,
                                       const EncodedStep& step) const {
  const double triangles = size_of(step).triangles;
  if (max_triangles_ == 0 || triangles <= max_triangles()) return {};
  if (request.cell) {
    return fail(ErrorCode::kLimitExceeded,
                "The surface in the cell has " +
                    std::to_string(static_cast<std::uint64_t>(triangles)) +
                    " triangles; this server sends at most " + std::to_string(max_triangles_) +
                    "; request its octants, or allow a larger error.");
  }
  const double expected = accurate_sizes()({.request = request}).triangles;
  return fail(ErrorCode::kLimitExceeded,
              limit_error_text("", triangles, request,
                               expected > 0 ? std::max(triangles / expected, 1.0) : 1));
}

std::function<SurfaceSize(const StepRequest&)> TriangleLimit::accurate_sizes() const {
  return source_.sizes(stop_, SizeAccuracy::kAccurate).of;
}

std::string TriangleLimit::limit_error_text(const std::string& about, double triangles,
                                            IsosurfaceRequest request,
                                            double error_of_estimates) const {
  request.max_triangles =
      std::max<std::uint64_t>(static_cast<std::uint64_t>(max_triangles() / error_of_estimates), 1);
  request.max_bytes = 0;
  const auto size_of_request = accurate_sizes();
  const IsosurfaceRequest fitting = within_budget(request, source_.info(), size_of_request);
  std::string text = "The surface has " + about +
                     std::to_string(static_cast<std::uint64_t>(triangles)) +
                     " triangles; this server sends at most " + std::to_string(max_triangles_);
  if (!fits(size_of_request({.request = fitting}), request)) return text + ".";
  const double error = std::max(fitting.error, fitting.thresholds.error_floor);
  text += "; it fits with an error of " + shortest_text(error) + " " +
          std::string(name(request.unit)) + (request.unit == ErrorUnit::kVoxel ? "s" : " units");
  return text + ", or set a budget with max_triangles.";
}

}  // namespace multitetra
