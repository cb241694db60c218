#include "common/base/json.hpp"
#include "server/volume/formats/arrays/conventions/known_conventions.hpp"

namespace multitetra {

std::vector<std::string> axistags_arrays(const ArrayContainer& file, const VolumeChoice&) {
  std::vector<std::string> found = file.arrays();
  std::erase_if(found,
                [&](const std::string& array) { return file.texts(array, "axistags").empty(); });
  return found;
}

// {"axes": [{"key": "z", "resolution": 2.0, "description": "um"}, ...]}, in the order of the
// dimensions; a resolution of 0 is unknown.
bool describe_axistags(const ArrayContainer& file, const std::string& array,
                       ArrayMeaning& meaning) {
  const nlohmann::json tags = parse_json(file.text(array, "axistags"));
  const std::size_t rank = file.shape(array).size();
  if (!tags.is_object() || !tags.contains("axes") || !tags["axes"].is_array()) return false;
  std::vector<std::string> names;
  for (const nlohmann::json& axis : tags["axes"]) {
    const nlohmann::json key = axis.is_object() ? axis.value("key", nlohmann::json()) : axis;
    names.push_back(key.is_string() ? key.get<std::string>() : std::string());
  }
  meaning.roles = roles_from(names);
  if (meaning.roles.size() != rank) return false;
  if (meaning.roles.back() == DimensionRole::kChannel) {
    meaning.roles.back() = DimensionRole::kComponent;
  }
  StatedNumbers steps = kNotStated;
  std::array<std::string, 3> units;
  for (std::size_t d = 0; d < rank; ++d) {
    if (meaning.roles[d] > DimensionRole::kZ) continue;
    const auto axis = static_cast<std::size_t>(meaning.roles[d]);
    const nlohmann::json& tag = tags["axes"][d];
    if (!tag.is_object()) continue;
    const nlohmann::json step = tag.value("resolution", nlohmann::json());
    const nlohmann::json unit = tag.value("unit", nlohmann::json());
    if (step.is_number()) steps[axis] = stated_spacing(step.get<double>());
    if (steps[axis] && unit.is_string()) units[axis] = unit.get<std::string>();
  }
  set_box_axes(meaning.header, kNotStated, steps);
  set_units_of_axes(meaning.header, units);
  return true;
}

}  // namespace multitetra
