#include "server/volume/formats/stated_geometry.hpp"

#include <algorithm>
#include <cstddef>

#include "common/base/vec3.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

StatedNumbers finite_ones(StatedNumbers numbers) {
  for (std::optional<double>& number : numbers) {
    if (number && !std::isfinite(*number)) number.reset();
  }
  return numbers;
}

}  // namespace

void set_box_axes(ImageHeader& header, const StatedNumbers& origin, const StatedNumbers& steps) {
  std::array<Vec3, 3> axes{};
  for (std::size_t axis = 0; axis < 3; ++axis) axes[axis][axis] = steps[axis].value_or(0);
  set_axes(header, axes, origin);
}

void set_axes(ImageHeader& header, const std::array<Vec3, 3>& steps, const StatedNumbers& origin) {
  header.geometry = {.origin = finite_ones(origin)};
  auto& [axes, spacing, first] = header.geometry;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    spacing[axis] = stated_spacing(length(steps[axis]));
    if (spacing[axis]) axes[axis] = sum(steps[axis], {0, 0, 0});  // Turns -0 into 0.
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (spacing[axis]) continue;
    // An image in space; its slices follow each other along z unless it is tilted.
    const Vec3 normal = cross(axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
    if (std::abs(dot(normal, axes[axis])) < 0.999 * length(normal)) {
      axes[axis] = scaled(normal, 1 / length(normal));
    }
  }
}

void set_units_of_axes(ImageHeader& header, const std::array<std::string, 3>& units) {
  std::string& common = header.meaning.length_unit;
  const auto first = std::find_if(units.begin(), units.end(), [](auto& u) { return !u.empty(); });
  if (first == units.end()) return;
  common = unit_from(*first);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string unit = unit_from(units[axis]);
    if (unit == common || units[axis].empty()) continue;
    const std::optional<double> known = length_factor(unit, common);
    if (!known) {
      header.contradictions.push_back({Fact::kLengthUnit, "its axes have no common unit: '" +
                                                              *first + "' and '" + units[axis] +
                                                              "'. Give it with --length-unit"});
      common.clear();
      return;
    }
    const double factor = *known;
    std::optional<double>& spacing = header.geometry.spacing[axis];
    if (spacing) {
      *spacing *= factor;
      header.geometry.axes[axis] = scaled(header.geometry.axes[axis], factor);
    }
    if (header.geometry.origin[axis]) *header.geometry.origin[axis] *= factor;
  }
}

}  // namespace multitetra
