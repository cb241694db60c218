#include "server/volume/formats/arrays/conventions/known_conventions.hpp"

namespace multitetra {
namespace {

// "/DataContainers/NAME" of an array "/DataContainers/NAME/CellData/Phases".
std::string container_of(const std::string& array) {
  const std::string group = group_of(group_of(array));
  return group.starts_with("/DataContainers/") ? group : std::string();
}

}  // namespace

std::vector<std::string> dream3d_arrays(const ArrayContainer& file, const VolumeChoice&) {
  std::vector<std::string> found = file.arrays();
  std::erase_if(found, [&](const std::string& array) {
    const std::string container = container_of(array);
    return container.empty() || file.shape(container + "/_SIMPL_GEOMETRY/SPACING").empty() ||
           file.numbers(array, "ComponentDimensions").empty();
  });
  return found;
}

// Cells (z, y, x, components) on a grid whose origin is a corner of the first cell.
bool describe_dream3d(const ArrayContainer& file, const std::string& array, ArrayMeaning& meaning) {
  const std::string geometry = container_of(array) + "/_SIMPL_GEOMETRY/";
  if (geometry.front() != '/' || container_of(array).empty()) return false;
  const std::vector<double> spacing = file.values(geometry + "SPACING");
  const std::vector<double> corner = file.values(geometry + "ORIGIN");
  if (spacing.size() != 3 || file.shape(array).size() != 4) return false;
  meaning.roles = {DimensionRole::kZ, DimensionRole::kY, DimensionRole::kX,
                   DimensionRole::kComponent};
  StatedNumbers origin = kNotStated;
  for (std::size_t axis = 0; axis < 3 && corner.size() == 3; ++axis) {
    origin[axis] = corner[axis] + spacing[axis] / 2;
  }
  set_box_axes(meaning.header, origin, stated({spacing[0], spacing[1], spacing[2]}));
  return true;
}

}  // namespace multitetra
