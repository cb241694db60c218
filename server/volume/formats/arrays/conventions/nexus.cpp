#include <algorithm>

#include "common/base/text.hpp"
#include "server/volume/formats/arrays/conventions/known_conventions.hpp"

namespace multitetra {
namespace {

// The signal of an NXdata group: by its attribute, or, as before 2014, by one of the array.
std::string signal_of(const ArrayContainer& file, const std::string& group) {
  const std::string named = file.text(group, "signal");
  if (!named.empty()) return group + "/" + named;
  for (const std::string& name : file.children(group)) {
    const std::string array = group + "/" + name;
    if (file.number(array, "signal", 0) == 1 || file.text(array, "signal") == "1") return array;
  }
  return {};
}

// Names for each dimension; "." for none. Written in the group, or in the signal as "z:y:x".
std::vector<std::string> axes_of(const ArrayContainer& file, const std::string& group,
                                 const std::string& array) {
  std::vector<std::string> axes = file.texts(group, "axes");
  if (axes.empty()) axes = file.texts(array, "axes");
  if (axes.size() != 1) return axes;
  std::string text = axes[0];
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == ',' || c == '[' || c == ']'; }, ':');
  axes.clear();
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(':', at), text.size());
    if (end > at) axes.emplace_back(trimmed(std::string_view(text).substr(at, end - at)));
    at = end + 1;
  }
  return axes;
}

// Stored integers stand for values: value = scaling factor * integer + offset, by fields beside the
// array that are named after it, or apply to the signal.
void unpack_by_fields(const ArrayContainer& file, const std::string& array, ImageHeader& header) {
  const bool is_signal = signal_of(file, group_of(array)) == array;
  const auto number = [&](const std::string& name, double otherwise) {
    std::vector<double> found = file.values(array + "_" + name);
    if (found.empty() && is_signal) found = file.values(group_of(array) + "/" + name);
    if (found.size() != 1) return otherwise;
    header.values.scaling = Basis::kStated;
    return found[0];
  };
  const double factor = number("scaling_factor", 1);
  header.slope *= factor;
  header.intercept = header.intercept * factor + number("offset", 0);
}

}  // namespace

std::vector<std::string> nexus_arrays(const ArrayContainer& file, const VolumeChoice&) {
  std::vector<std::string> found = file.arrays();
  std::erase_if(found, [&](const std::string& array) {
    const std::string group = group_of(array);
    return file.text(group, "NX_class") != "NXdata" || signal_of(file, group) != array;
  });
  // The path of `default` leads to the plot that its author chose.
  std::string place;
  for (std::string next = file.text("", "default"); !next.empty() && place.size() < 1000;) {
    place += "/" + next;
    next = file.text(place, "default");
  }
  const auto chosen = std::find(found.begin(), found.end(), signal_of(file, place));
  return chosen == found.end() ? found : std::vector{*chosen};
}

bool describe_nexus(const ArrayContainer& file, const std::string& array, ArrayMeaning& meaning) {
  const std::string group = group_of(array);
  if (file.text(group, "NX_class") != "NXdata") return false;
  const std::vector<std::int64_t> shape = file.shape(array);
  const std::vector<std::string> axes = axes_of(file, group, array);
  meaning.roles = roles_from(axes);
  if (meaning.roles.size() != shape.size()) meaning.roles = roles_by_place(shape);
  std::vector<AxisCoordinates> coordinates(shape.size());
  for (std::size_t d = 0; d < axes.size() && axes.size() == shape.size(); ++d) {
    const std::string along = group + "/" + axes[d];
    coordinates[d] = coordinates_in(file, along);
    std::vector<double>& values = coordinates[d].values;
    if (std::ssize(values) == shape[d] + 1) {  // Edges of bins.
      for (std::size_t i = 0; i + 1 < values.size(); ++i)
        values[i] = (values[i] + values[i + 1]) / 2;
      values.pop_back();
    }
    if (std::ssize(values) != shape[d]) coordinates[d] = {};
  }
  place_by_coordinates(coordinates, meaning);
  unpack_by_attributes(file, array, meaning);
  unpack_by_fields(file, array, meaning.header);
  return true;
}

}  // namespace multitetra
