#include "common/isosurface_request.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <string>

namespace multitetra {
namespace {

std::string describe(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "infinity" : "-infinity";
  std::array<char, 32> text{};  // The shortest decimal that reads back as the same number.
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

}  // namespace

std::string_view name(ErrorMeasure measure) {
  return measure == ErrorMeasure::kCertified ? "certified" : "paper";
}
std::string_view name(TopologyRule rule) {
  return rule == TopologyRule::kExact ? "exact" : "paper";
}
std::string_view name(LengthUnit unit) { return unit == LengthUnit::kVoxel ? "voxel" : "world"; }

std::optional<ErrorMeasure> error_measure_from(std::string_view name) {
  if (name == "certified") return ErrorMeasure::kCertified;
  if (name == "paper") return ErrorMeasure::kPaper;
  return std::nullopt;
}
std::optional<TopologyRule> topology_rule_from(std::string_view name) {
  if (name == "exact") return TopologyRule::kExact;
  if (name == "paper") return TopologyRule::kPaper;
  return std::nullopt;
}
std::optional<LengthUnit> length_unit_from(std::string_view name) {
  if (name == "voxel") return LengthUnit::kVoxel;
  if (name == "world") return LengthUnit::kWorld;
  return std::nullopt;
}

Result<IsosurfaceRequest> validated(const IsosurfaceRequest& request) {
  const auto reject = [](std::string text) {
    return fail(ErrorCode::kInvalidArgument, std::move(text));
  };
  const auto is_length = [](double value) { return std::isfinite(value) && value >= 0; };
  if (!std::isfinite(request.isovalue)) {
    return reject("The isovalue is " + describe(request.isovalue) +
                  "; it must be a finite number.");
  }
  if (!is_length(request.error)) {
    return reject("The error threshold is " + describe(request.error) +
                  "; it must be a finite number, 0 or greater.");
  }
  if (!is_length(request.topology_tolerance)) {
    return reject("The topology tolerance is " + describe(request.topology_tolerance) +
                  "; it must be a finite number of voxels, 0 or greater.");
  }
  if (request.lattice_resolution < kMinLatticeResolution ||
      request.lattice_resolution > kMaxLatticeResolution) {
    return reject("The lattice resolution is " + std::to_string(request.lattice_resolution) +
                  "; it must be from " + std::to_string(kMinLatticeResolution) + " to " +
                  std::to_string(kMaxLatticeResolution) + ".");
  }
  return request;
}

}  // namespace multitetra
