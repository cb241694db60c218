#include <algorithm>

#include "server/volume/formats/arrays/conventions/known_conventions.hpp"

namespace multitetra {
namespace {

// A mesh is a scalar array, or a group with an array for each component.
std::string mesh_of(const ArrayContainer& file, const std::string& array) {
  for (const std::string& object : {array, group_of(array)}) {
    if (!file.texts(object, "axisLabels").empty()) return object;
  }
  return {};
}

}  // namespace

std::vector<std::string> openpmd_arrays(const ArrayContainer& file, const VolumeChoice&) {
  std::vector<std::string> found = file.arrays();
  std::erase_if(found, [&](const std::string& array) { return mesh_of(file, array).empty(); });
  return found;
}

bool describe_openpmd(const ArrayContainer& file, const std::string& array, ArrayMeaning& meaning) {
  const std::string mesh = mesh_of(file, array);
  if (mesh.empty()) return false;
  // Everything of the mesh is in the order of the labels, which `dataOrder` F reverses.
  std::vector<std::string> labels = file.texts(mesh, "axisLabels");
  std::vector<double> spacing = file.numbers(mesh, "gridSpacing");
  std::vector<double> offset = file.numbers(mesh, "gridGlobalOffset");
  std::vector<double> position = file.numbers(array, "position");
  const std::size_t rank = file.shape(array).size();
  if (file.text(mesh, "dataOrder") == "F") {
    for (auto* list : {&spacing, &offset, &position}) std::reverse(list->begin(), list->end());
    std::reverse(labels.begin(), labels.end());
  }
  meaning.roles = roles_from(labels);
  if (const std::vector<double> unit = file.numbers(array, "unitSI"); !unit.empty()) {
    meaning.header.slope = unit[0];
    meaning.header.values.scaling = Basis::kStated;
  }
  const std::string geometry = file.text(mesh, "geometry");
  if (meaning.roles.size() != rank || (!geometry.empty() && geometry != "cartesian")) {
    meaning.roles = roles_by_place(file.shape(array));
    meaning.is_geometry_unread = true;
    return true;
  }
  const double unit = file.number(mesh, "gridUnitSI", 1);
  StatedNumbers origin = kNotStated;
  StatedNumbers steps = kNotStated;
  for (std::size_t d = 0; d < rank && spacing.size() == rank; ++d) {
    if (meaning.roles[d] > DimensionRole::kZ) continue;
    const auto axis = static_cast<std::size_t>(meaning.roles[d]);
    steps[axis] = stated_spacing(spacing[d] * unit);
    if (offset.size() != rank) continue;
    // The position of a sample in its cell, as a share of the spacing.
    const double in_cell = position.size() == rank ? position[d] : 0;
    origin[axis] = (offset[d] + in_cell * spacing[d]) * unit;
  }
  set_box_axes(meaning.header, origin, steps);
  meaning.header.meaning.length_unit = "m";
  return true;
}

}  // namespace multitetra
