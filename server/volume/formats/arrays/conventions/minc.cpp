#include <algorithm>
#include <limits>
#include <set>

#include "common/base/text.hpp"
#include "server/volume/formats/arrays/conventions/known_conventions.hpp"

namespace multitetra {
namespace {

struct MincPlace {
  std::string image;       // The array.
  std::string dimensions;  // Before the name of a dimension.
  std::string scales;      // Before "image-min" and "image-max".
};

// MINC 2 is HDF5 with a group of this name; MINC 1 is NetCDF with variables at the top.
MincPlace minc_place(const ArrayContainer& file) {
  if (file.text("/minc-2.0/image/0/image", "dimorder").empty()) return {"/image", "/", "/"};
  return {"/minc-2.0/image/0/image", "/minc-2.0/dimensions/", "/minc-2.0/image/0/"};
}

std::vector<std::string> minc_dimensions(const ArrayContainer& file, const MincPlace& place) {
  std::string order = file.text(place.image, "dimorder");
  if (order.empty()) return file.dimension_names(place.image);
  std::vector<std::string> names;
  for (std::replace(order.begin(), order.end(), ',', ' '); !trimmed(order).empty();) {
    const std::string_view rest = trimmed(order);
    const std::size_t end = std::min(rest.find(' '), rest.size());
    names.emplace_back(rest.substr(0, end));
    order = std::string(rest.substr(end));
  }
  return names;
}

// An integer image is stored in a range that stands for that of image-min and image-max, which may
// differ between slices.
void set_scales(const ArrayContainer& file, const MincPlace& place, StoredType type,
                ArrayMeaning& meaning) {
  if (type == StoredType::kF32 || type == StoredType::kF64) return;
  std::vector<double> range = file.numbers(place.image, "valid_range");
  if (range.size() != 2 || !(range[0] < range[1])) {
    with_number_type(type, [&]<typename Number>() {
      range = {static_cast<double>(std::numeric_limits<Number>::lowest()),
               static_cast<double>(std::numeric_limits<Number>::max())};
    });
  }
  const std::vector<double> low = file.values(place.scales + "image-min");
  const std::vector<double> high = file.values(place.scales + "image-max");
  if (low.empty() || low.size() != high.size()) {
    meaning.header.contradictions.push_back(
        {Fact::kScaling, "it has no image-min and image-max; the values are those stored"});
    meaning.header.values.scaling = Basis::kAssumed;
    return;
  }
  meaning.header.values.scaling = Basis::kStated;
  for (std::size_t i = 0; i < low.size(); ++i) {
    const double slope = (high[i] - low[i]) / (range[1] - range[0]);
    meaning.scales.push_back({slope, low[i] - slope * range[0]});
  }
}

}  // namespace

std::vector<std::string> minc_arrays(const ArrayContainer& file, const VolumeChoice&) {
  const MincPlace place = minc_place(file);
  const bool is_minc = !file.texts(place.image, "dimorder").empty() ||
                       file.text(place.image, "varid") == "MINC standard variable";
  return is_minc ? std::vector{place.image} : std::vector<std::string>();
}

bool describe_minc(const ArrayContainer& file, const std::string& array, ArrayMeaning& meaning) {
  const MincPlace place = minc_place(file);
  if (array != place.image || minc_arrays(file, {}).empty()) return false;
  const std::vector<std::string> names = minc_dimensions(file, place);
  if (names.size() != file.shape(array).size()) return false;
  // Bytes are unsigned unless MINC 1 says otherwise; MINC 2 has types of its own.
  const std::string sign = lower_case(file.text(array, "signtype"));
  const bool is_byte = bytes_of(*file.type(array)) == 1 && array == "/image";
  meaning.is_unsigned = sign == "unsigned" || (sign.empty() && is_byte);
  // The coordinates are those of the patient, to the right, front and head, whatever the order.
  std::array<Vec3, 3> steps{};
  Vec3 origin{};
  bool has_origin = true;
  std::set<std::string> units;
  std::size_t axis = 3;
  for (const std::string& name : names) {
    if (name == "time") meaning.roles.push_back(DimensionRole::kTime);
    if (name == "vector_dimension") meaning.roles.push_back(DimensionRole::kComponent);
    const std::size_t along = std::string_view("xyz").find(name.substr(0, 1));
    if (!name.ends_with("space") || along > 2 || axis == 0) continue;
    meaning.roles.push_back(static_cast<DimensionRole>(--axis));
    const std::string dimension = place.dimensions + name;
    const std::vector<double> step = file.numbers(dimension, "step");
    units.insert(unit_from(file.text(dimension, "units")));
    const std::vector<double> start = file.numbers(dimension, "start");
    const std::vector<double> cosines = file.numbers(dimension, "direction_cosines");
    Vec3 direction{};
    direction[along] = 1;
    if (cosines.size() == 3) direction = {cosines[0], cosines[1], cosines[2]};
    if (length(direction) > 0) direction = scaled(direction, 1 / length(direction));
    if (step.size() == 1) steps[axis] = scaled(direction, step[0]);
    if (file.text(dimension, "spacing") == "irregular") {
      meaning.header.contradictions.push_back(
          {Fact::kSpacing, "its positions along " + name + " are irregular; its step is used"});
    }
    has_origin = has_origin && start.size() == 1;
    if (start.size() == 1) origin = moved(origin, start[0], direction);
  }
  if (meaning.roles.size() != names.size() || axis != 0) return false;
  ras_to_lps(meaning.header, steps, origin);
  set_axes(meaning.header, steps, has_origin ? stated(origin) : kNotStated);
  units.erase("");
  meaning.header.meaning = {.space = WorldSpace::kLps,
                            .length_unit = units.empty() ? "mm" : *units.begin()};
  if (units.size() > 1) {
    meaning.header.contradictions.push_back(
        {Fact::kLengthUnit, "its axes have several units; " + *units.begin() + " is used"});
  }
  const StoredType type = *file.type(array);
  set_scales(file, place, meaning.is_unsigned ? unsigned_type(type) : type, meaning);
  return true;
}

}  // namespace multitetra
