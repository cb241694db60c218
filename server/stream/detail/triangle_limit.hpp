// The server's limit of triangles in a final step.
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>

#include "common/base/result.hpp"
#include "common/request/isosurface_request.hpp"
#include "server/core/planning/budget.hpp"
#include "server/stream/surface_provider.hpp"

namespace multitetra {

// Uses the provider, which must outlive it. Limit 0: none. Errors are kLimitExceeded, with an error
// that fits.
class TriangleLimit {
 public:
  TriangleLimit(const SurfaceProvider& source, std::uint64_t max_triangles, std::stop_token stop);

  // Rejects requests that a quick estimate shows to exceed the limit for certain. Reads samples
  // only if the spectrum's estimate, which may err either way, exceeds it.
  [[nodiscard]] Result<void> check_estimate(const IsosurfaceRequest& request,
                                            const SizeEstimates& sizes) const;
  [[nodiscard]] Result<void> check_made(const IsosurfaceRequest& request,
                                        const EncodedStep& step) const;

 private:
  [[nodiscard]] double max_triangles() const { return static_cast<double>(max_triangles_); }
  [[nodiscard]] std::function<SurfaceSize(const StepRequest&)> accurate_sizes() const;
  // `error_of_estimates` is the factor by which estimates are too small.
  [[nodiscard]] std::string limit_error_text(const std::string& about, double triangles,
                                             IsosurfaceRequest request,
                                             double error_of_estimates) const;

  const SurfaceProvider& source_;
  std::uint64_t max_triangles_;
  std::stop_token stop_;
};

}  // namespace multitetra
