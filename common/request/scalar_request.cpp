#include "common/request/scalar_request.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/dataset/same_world.hpp"

namespace multitetra {

std::uint32_t ScalarRange::code_of(double value) const {
  if (std::isnan(value)) return no_value();
  const double size = step();
  if (!(size > 0)) return 0;
  const double code = std::floor((value - low) / size + 0.5);
  return static_cast<std::uint32_t>(std::clamp(code, 0.0, static_cast<double>(no_value() - 1)));
}

float ScalarRange::value_of(std::uint32_t code) const {
  if (code >= no_value()) return std::numeric_limits<float>::quiet_NaN();
  return static_cast<float>(low + code * step());
}

Result<ScalarRequest> validated(const ScalarRequest& request) {
  if (request.bits != 8 && request.bits != 16) {
    return fail(ErrorCode::kInvalidArgument,
                "Scalars have " + std::to_string(request.bits) + " bits; they must have 8 or 16.");
  }
  if (request.limits &&
      !(std::isfinite(request.limits->low) && std::isfinite(request.limits->high) &&
        request.limits->low < request.limits->high)) {
    return fail(ErrorCode::kInvalidArgument,
                "The range of scalars must be two finite numbers in increasing order.");
  }
  return request;
}

ScalarRange range_for(const ScalarRequest& request, const DatasetInfo& field) {
  if (!request.limits) return {.low = field.min, .high = field.max, .bits = request.bits};
  return {.low = request.limits->low, .high = request.limits->high, .bits = request.bits};
}

Result<void> check_same_world(const ScalarRequest& request, const DatasetInfo& surface,
                              const DatasetInfo& field) {
  const std::string why = request.in_any_world ? "" : world_mismatch(surface, field);
  if (why.empty()) return {};
  return fail(ErrorCode::kInvalidArgument, why + " Use color_anyway to color by it anyway.");
}

}  // namespace multitetra
