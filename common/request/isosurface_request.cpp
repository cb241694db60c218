#include "common/request/isosurface_request.hpp"

#include <cmath>
#include <string>

#include "common/base/enum_names.hpp"
#include "common/base/number_text.hpp"

namespace multitetra {

namespace {

constexpr EnumNames<ErrorMeasure, 2> kMeasures = {{"certified", "paper"}};
constexpr EnumNames<TopologyRule, 2> kRules = {{"exact", "paper"}};
constexpr EnumNames<ErrorUnit, 2> kUnits = {{"voxel", "world"}};

}  // namespace

std::string_view name(ErrorMeasure measure) { return kMeasures.of(measure); }
std::string_view name(TopologyRule rule) { return kRules.of(rule); }
std::string_view name(ErrorUnit unit) { return kUnits.of(unit); }

std::optional<ErrorMeasure> error_measure_from(std::string_view name) {
  return kMeasures.find(name);
}
std::optional<TopologyRule> topology_rule_from(std::string_view name) { return kRules.find(name); }
std::optional<ErrorUnit> error_unit_from(std::string_view name) { return kUnits.find(name); }

Result<IsosurfaceRequest> validated(const IsosurfaceRequest& request) {
  const auto reject = [](std::string text) {
    return fail(ErrorCode::kInvalidArgument, std::move(text));
  };
  const auto is_length = [](double value) { return std::isfinite(value) && value >= 0; };
  if (!std::isfinite(request.isovalue)) {
    return reject("The isovalue is " + shortest_text(request.isovalue) +
                  "; it must be a finite number.");
  }
  if (!is_length(request.error)) {
    return reject("The error threshold is " + shortest_text(request.error) +
                  "; it must be a finite number, 0 or greater.");
  }
  if (!is_length(request.topology_tolerance)) {
    return reject("The topology tolerance is " + shortest_text(request.topology_tolerance) +
                  "; it must be a finite number of voxels, 0 or greater.");
  }
  if (request.lattice_resolution < kMinLatticeResolution ||
      request.lattice_resolution > kMaxLatticeResolution) {
    return reject("The lattice resolution is " + std::to_string(request.lattice_resolution) +
                  "; it must be from " + std::to_string(kMinLatticeResolution) + " to " +
                  std::to_string(kMaxLatticeResolution) + ".");
  }
  if (request.normal_bits != 0 &&
      (request.normal_bits < kMinNormalBits || request.normal_bits > kMaxNormalBits)) {
    return reject("The normals have " + std::to_string(request.normal_bits) +
                  " bits; they must have " + std::to_string(kMinNormalBits) + " to " +
                  std::to_string(kMaxNormalBits) + ", or 0 for none.");
  }
  if (request.cell) {
    if (const auto checked = check_cell(*request.cell); !checked) {
      return tl::unexpected(checked.error());
    }
    if (request.max_triangles > 0 || request.max_bytes > 0) {
      return reject(
          "A request for a cell has a budget; budgets apply to whole surfaces only. Omit "
          "max_triangles and max_bytes.");
    }
  }
  if (const auto checked = check_thresholds(request.thresholds); !checked) {
    return tl::unexpected(checked.error());
  }
  return request;
}

}  // namespace multitetra
