#include "server/volume/formats/detail/axis_coordinates.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>

namespace multitetra {
namespace {

// Returns the distance of evenly spaced values; nullopt for others.
std::optional<double> even_step(const std::vector<double>& values) {
  const double step = (values.back() - values.front()) / static_cast<double>(values.size() - 1);
  if (!std::isfinite(step) || step == 0) return std::nullopt;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double expected = values.front() + step * static_cast<double>(i);
    if (!(std::abs(values[i] - expected) <= 1e-3 * std::abs(step))) return std::nullopt;
  }
  return step;
}

}  // namespace

void place_by_coordinates(const std::filesystem::path& path,
                          const std::array<AxisCoordinates, 3>& coordinates, std::size_t axes,
                          ImageHeader& header, std::vector<std::string>& notices) {
  StatedNumbers origin = kNotStated;
  StatedNumbers spacing = kNotStated;
  std::set<std::string> units;
  for (std::size_t axis = 0; axis < axes; ++axis) {
    const auto& [values, unit, step] = coordinates[axis];
    if (step) {
      spacing[axis] = *step;
    } else if (values.size() >= 2) {
      const std::optional<double> even = even_step(values);
      if (!even) {
        units.emplace();
        notices.push_back("'" + path.string() + "': the coordinates along " +
                          std::string(1, "xyz"[axis]) +
                          " are not evenly spaced.");
        continue;
      }
      spacing[axis] = *even;
      origin[axis] = values.front();
    }
    units.insert(unit_from(unit));
  }
  if (units.size() == 1) header.meaning.length_unit = *units.begin();
  set_box_axes(header, origin, spacing);
}

}  // namespace multitetra
