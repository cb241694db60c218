#include "server/volume/formats/arrays/conventions/known_conventions.hpp"

namespace multitetra {

std::vector<std::string> vtkhdf_arrays(const ArrayContainer& file, const VolumeChoice&) {
  std::vector<std::string> found;
  if (file.text("/VTKHDF", "Type") != "ImageData") return found;
  for (const char* group : {"/VTKHDF/PointData", "/VTKHDF/CellData"}) {
    for (const std::string& name : file.children(group)) {
      const std::string path = std::string(group) + "/" + name;
      if (file.shape(path).size() >= 3) found.push_back(path);
    }
  }
  return found;
}

bool describe_vtkhdf(const ArrayContainer& file, const std::string& array, ArrayMeaning& meaning) {
  const std::string group = group_of(array);
  const bool of_cells = group == "/VTKHDF/CellData";
  const std::vector<double> spacing = file.numbers("/VTKHDF", "Spacing");
  const std::vector<double> origin = file.numbers("/VTKHDF", "Origin");
  std::vector<double> directions = file.numbers("/VTKHDF", "Direction");
  const std::vector<double> extent = file.numbers("/VTKHDF", "WholeExtent");
  const std::size_t rank = file.shape(array).size();
  if ((!of_cells && group != "/VTKHDF/PointData") || rank < 3 || rank > 4) return false;
  meaning.roles = {DimensionRole::kZ, DimensionRole::kY, DimensionRole::kX};
  if (rank == 4) meaning.roles.push_back(DimensionRole::kComponent);
  if (directions.size() != 9) directions = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::array<Vec3, 3> steps{};
  StatedNumbers first = kNotStated;
  for (std::size_t row = 0; row < 3; ++row) {
    if (origin.size() == 3) first[row] = origin[row];
    for (std::size_t axis = 0; axis < 3 && spacing.size() == 3; ++axis) {
      steps[axis][row] = directions[3 * row + axis] * spacing[axis];
      const double start = extent.size() == 6 ? extent[2 * axis] : 0;
      if (first[row]) *first[row] += steps[axis][row] * (start + (of_cells ? 0.5 : 0));
    }
  }
  set_axes(meaning.header, steps, first);
  return true;
}

}  // namespace multitetra
