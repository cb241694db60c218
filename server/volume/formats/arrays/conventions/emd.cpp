#include "server/volume/formats/arrays/conventions/known_conventions.hpp"

namespace multitetra {
namespace {

bool is_velox(const std::string& array) {
  return array.starts_with("/Data/Image/") && array.ends_with("/Data");
}

// "[n_m]" and "[µm]" are units in LaTeX.
std::string plain_unit(std::string unit) {
  std::erase_if(unit, [](char c) { return c == '[' || c == ']' || c == '_'; });
  return unit;
}

}  // namespace

std::vector<std::string> emd_arrays(const ArrayContainer& file, const VolumeChoice&) {
  std::vector<std::string> found = file.arrays();
  const bool is_velox_file =
      !file.shape("/Version").empty() || !file.children("/Data/Image").empty();
  std::erase_if(found, [&](const std::string& array) {
    const std::string group = group_of(array);
    const bool is_data = array == group + "/data";
    const bool is_emd = !file.numbers(group, "emd_group_type").empty() ||
                        !file.texts(group, "emd_group_type").empty();
    return !(is_data && is_emd) && !(is_velox_file && is_velox(array));
  });
  return found;
}

// An array `data` with its coordinates beside it: dim1, dim2, ... (Berkeley Lab) or dim0, dim1, ...
// (EMD 1.0), each with `name` and `units`; two values may stand for evenly spaced ones. Velox
// (Thermo Fisher) has (y, x, frame) and states its geometry in an array of JSON texts.
bool describe_emd(const ArrayContainer& file, const std::string& array, ArrayMeaning& meaning) {
  const std::vector<std::int64_t> shape = file.shape(array);
  if (is_velox(array) && shape.size() == 3) {
    meaning.name = "EMD of Velox";
    meaning.roles = {DimensionRole::kY, DimensionRole::kX, DimensionRole::kZ};
    meaning.is_geometry_unread = true;
    return true;
  }
  const std::string group = group_of(array);
  if (file.numbers(group, "emd_group_type").empty() && file.texts(group, "emd_group_type").empty())
    return false;
  const std::size_t first = file.shape(group + "/dim0").empty() ? 1 : 0;
  std::vector<std::string> names(shape.size());
  std::vector<AxisCoordinates> coordinates(shape.size());
  for (std::size_t d = 0; d < shape.size(); ++d) {
    const std::string along = group + "/dim" + std::to_string(first + d);
    names[d] = file.text(along, "name");
    coordinates[d] = coordinates_in(file, along);
    coordinates[d].unit = plain_unit(coordinates[d].unit);
    std::vector<double>& values = coordinates[d].values;
    if (values.size() == 2) {
      for (std::int64_t i = 2; i < std::min<std::int64_t>(shape[d], kMaxSide); ++i) {
        values.push_back(values[0] + static_cast<double>(i) * (values[1] - values[0]));
      }
    }
    if (std::ssize(values) != shape[d]) coordinates[d] = {};
  }
  meaning.roles = roles_from(names);
  if (meaning.roles.size() != shape.size()) meaning.roles = roles_by_place(shape);
  place_by_coordinates(coordinates, meaning);
  return true;
}

}  // namespace multitetra
