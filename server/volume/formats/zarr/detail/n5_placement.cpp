#include "server/volume/formats/zarr/detail/n5_placement.hpp"

#include <optional>
#include <vector>

namespace multitetra {
namespace {

using Json = nlohmann::json;

// Returns an attribute of the array, or else of its group; null if neither has it.
Json attribute_of(const ZarrContainer& file, const std::string& array, const char* name) {
  for (const std::string& path : {array, group_of(array)}) {
    const Json& attributes = file.attributes(path);
    if (attributes.is_object() && attributes.contains(name)) return attributes.at(name);
  }
  return {};
}

std::vector<double> numbers_in(const Json& list) {
  std::vector<double> numbers;
  if (!list.is_array()) return numbers;
  for (const Json& number : list) {
    if (!number.is_number()) return {};
    numbers.push_back(number.get<double>());
  }
  return numbers;
}

// One text, or one for each axis.
std::array<std::string, 3> units_in(const Json& units) {
  std::array<std::string, 3> texts;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Json unit = units.is_array() ? (axis < units.size() ? units[axis] : Json()) : units;
    if (unit.is_string()) texts[axis] = unit.get<std::string>();
  }
  return texts;
}

// By the names of the axes, in any order.
bool place_by_transform(const Json& transform, ArrayMeaning& meaning) {
  if (!transform.is_object()) return false;
  const std::vector<double> scale = numbers_in(transform.value("scale", Json()));
  const std::vector<double> translate = numbers_in(transform.value("translate", Json()));
  const Json axes = transform.value("axes", Json());
  const Json units = transform.value("units", Json());
  if (!axes.is_array() || axes.size() != scale.size()) return false;
  StatedNumbers origin = kNotStated;
  StatedNumbers steps = kNotStated;
  std::array<std::string, 3> unit_of_axis;
  for (std::size_t i = 0; i < scale.size(); ++i) {
    const std::string name = axes[i].is_string() ? axes[i].get<std::string>() : std::string();
    const std::size_t axis = std::string_view("xyz").find(name);
    if (name.size() != 1 || axis > 2) continue;
    steps[axis] = scale[i];
    if (translate.size() == scale.size()) origin[axis] = translate[i];
    const bool has_unit = units.is_array() && i < units.size() && units[i].is_string();
    if (has_unit) unit_of_axis[axis] = units[i].get<std::string>();
  }
  set_box_axes(meaning.header, origin, steps);
  set_units_of_axes(meaning.header, unit_of_axis);
  return true;
}

}  // namespace

// Lists are in the order x, y, z of N5.
void place_n5(const ZarrContainer& file, const std::string& array, ArrayMeaning& meaning) {
  meaning.roles = roles_by_place(file.shape(array));
  meaning.are_roles_by_place = true;
  if (place_by_transform(attribute_of(file, array, "transform"), meaning)) return;
  Json resolution = attribute_of(file, array, "pixelResolution");
  if (resolution.is_null()) resolution = attribute_of(file, array, "resolution");
  Json units = attribute_of(file, array, "units");
  if (resolution.is_object()) {
    if (resolution.contains("unit")) units = resolution.at("unit");
    resolution = resolution.value("dimensions", Json());
  }
  const std::vector<double> voxel = numbers_in(resolution);
  const std::vector<double> factors = numbers_in(attribute_of(file, array, "downsamplingFactors"));
  const std::vector<double> offset = numbers_in(attribute_of(file, array, "offset"));
  StatedNumbers origin = kNotStated;
  StatedNumbers steps = kNotStated;
  for (std::size_t axis = 0; axis < std::min<std::size_t>(voxel.size(), 3); ++axis) {
    const bool is_reduced = factors.size() == voxel.size();
    steps[axis] = stated_spacing(voxel[axis] * (is_reduced ? factors[axis] : 1));
    // A sample of a reduced level is the mean of those of the finest one.
    if (is_reduced) origin[axis] = voxel[axis] * (factors[axis] - 1) / 2;
    if (offset.size() == voxel.size()) origin[axis] = origin[axis].value_or(0) + offset[axis];
  }
  set_box_axes(meaning.header, origin, steps);
  if (!voxel.empty()) set_units_of_axes(meaning.header, units_in(units));
}

}  // namespace multitetra
