#include "server/volume/formats/arrays/conventions/known_conventions.hpp"

namespace multitetra {

namespace {

constexpr const char* kRoot = "/VTKHDF";
constexpr const char* kCellData = "/VTKHDF/CellData";
constexpr const char* kPointData = "/VTKHDF/PointData";

std::string type_in(const ArrayContainer& file) { return file.text(kRoot, "Type"); }

// Sets the roles of dimensions: z, y, x, before them the time steps if there are several, behind
// them components. Fails unless the sides are those of the extent.
void set_roles(const ArrayContainer& file, const std::string& array, bool of_cells,
               ArrayMeaning& meaning) {
  const std::vector<std::int64_t> shape = file.shape(array);
  const std::vector<double> extent = file.numbers(kRoot, "WholeExtent");
  const std::vector<double> times = file.values("/VTKHDF/Steps/Values");
  const bool has_times = times.size() > 1 && shape.size() > 3 && std::ssize(times) == shape[0];
  const std::size_t first = has_times ? 1 : 0;
  if (has_times) {
    meaning.roles = {DimensionRole::kTime};
    meaning.times = {.count = shape[0], .at = times};
  }
  bool are_sides = shape.size() == first + 3 || shape.size() == first + 4;
  for (std::size_t axis = 0; are_sides && axis < 3 && extent.size() == 6; ++axis) {
    const double side = extent[2 * axis + 1] - extent[2 * axis] + (of_cells ? 0 : 1);
    are_sides = static_cast<double>(shape[first + 2 - axis]) == side;
  }
  if (!are_sides) {
    fail_reading(file.file(), "the sides of its '" + array + "' are not those of its WholeExtent",
                 "Write a dimension for the time steps, or each into a file of its own");
  }
  meaning.roles.insert(meaning.roles.end(),
                       {DimensionRole::kZ, DimensionRole::kY, DimensionRole::kX});
  if (shape.size() == first + 4) meaning.roles.push_back(DimensionRole::kComponent);
}

}  // namespace

std::vector<std::string> vtkhdf_arrays(const ArrayContainer& file, const VolumeChoice&) {
  std::vector<std::string> found;
  if (type_in(file) != "ImageData") return found;
  for (const char* group : {kPointData, kCellData}) {
    for (const std::string& name : file.children(group)) {
      const std::string path = std::string(group) + "/" + name;
      if (file.shape(path).size() >= 3) found.push_back(path);
    }
  }
  return found;
}

bool describe_vtkhdf(const ArrayContainer& file, const std::string& array, ArrayMeaning& meaning) {
  const std::string type = type_in(file);
  if (type.empty() || !array.starts_with("/VTKHDF/")) return false;
  const std::string group = group_of(array);
  const bool of_cells = group == kCellData;
  if (type != "ImageData" || (!of_cells && group != kPointData)) {
    meaning.name = "VTKHDF of type " + type;
    meaning.is_geometry_unread = true;
    return true;
  }
  const std::vector<double> spacing = file.numbers(kRoot, "Spacing");
  const std::vector<double> origin = file.numbers(kRoot, "Origin");
  std::vector<double> directions = file.numbers(kRoot, "Direction");
  const std::vector<double> extent = file.numbers(kRoot, "WholeExtent");
  set_roles(file, array, of_cells, meaning);
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
