#include "server/volume/formats/arrays/conventions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/text.hpp"
#include "server/volume/formats/arrays/conventions/known_conventions.hpp"

namespace multitetra {
namespace {

// Values may be scaled or missing by attributes.
constexpr ValueBasis kWithoutStatements = {Basis::kAssumed, Basis::kStated, Basis::kAssumed};

constexpr std::array kConventions = {
    ArrayConvention{"MINC", kNumbersAsStored, &minc_arrays, &describe_minc},
    ArrayConvention{"VTKHDF", kNumbersAsStored, &vtkhdf_arrays, &describe_vtkhdf},
    ArrayConvention{"openPMD", kWithoutStatements, &openpmd_arrays, &describe_openpmd},
    ArrayConvention{"NeXus NXdata", kWithoutStatements, &nexus_arrays, &describe_nexus},
    ArrayConvention{"EMD", kNumbersAsStored, &emd_arrays, &describe_emd},
    ArrayConvention{"BigDataViewer", kNumbersAsStored, &big_data_viewer_arrays,
                    &describe_big_data_viewer},
    ArrayConvention{"axistags", kNumbersAsStored, &axistags_arrays, &describe_axistags},
    ArrayConvention{"Imaris", kNumbersAsStored, &imaris_arrays, &describe_imaris},
    ArrayConvention{"ITK", kNumbersAsStored, &itk_arrays, &describe_itk},
    ArrayConvention{"DREAM.3D", kNumbersAsStored, &dream3d_arrays, &describe_dream3d},
};

// Returns the distance of evenly spaced values; nullopt for others.
std::optional<double> even_step(const AxisCoordinates& coordinates) {
  const std::vector<double>& values = coordinates.values;
  const double step = (values.back() - values.front()) / static_cast<double>(values.size() - 1);
  if (!std::isfinite(step) || step == 0) return std::nullopt;
  const double tolerance =
      std::min(1e-3 * std::abs(step) + 2 * coordinates.rounding, 0.25 * std::abs(step));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double expected = values.front() + step * static_cast<double>(i);
    if (!(std::abs(values[i] - expected) <= tolerance)) return std::nullopt;
  }
  return step;
}

void set_times(const AxisCoordinates& coordinates, SourceTimes& times) {
  const std::vector<double>& values = coordinates.values;
  times.count = std::ssize(values);
  const bool are_times =
      std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  if (values.size() < 2 || values.size() > kMaxSourceMembers || !are_times) return;
  times.at = values;
  times.unit = time_unit_from(coordinates.unit);
}

// Returns x, y, z or time if the attributes of coordinates say that they are these (CF conventions,
// chapters 4 and 5); else empty.
std::string axis_said_by(const ArrayContainer& file, const std::string& along) {
  const std::string axis = lower_case(file.text(along, "axis"));
  if (axis == "t") return "time";
  if (axis == "x" || axis == "y" || axis == "z") return axis;
  const std::string unit = file.text(along, "units");
  const std::string name = file.text(along, "standard_name");
  const auto is_degrees = [&](std::string_view word, char letter) {
    return unit.starts_with("degree") && (unit.ends_with(word) || unit.ends_with(letter));
  };
  if (name.ends_with("longitude") || name == "projection_x_coordinate" || is_degrees("east", 'E'))
    return "x";
  if (name.ends_with("latitude") || name == "projection_y_coordinate" || is_degrees("north", 'N'))
    return "y";
  if (name == "time" || unit.find(" since ") != std::string::npos) return "time";
  return file.text(along, "positive").empty() ? std::string() : "z";
}

// Returns the roles that attributes of coordinates and names of dimensions say; empty if they do
// not say which are x and y.
std::vector<DimensionRole> stated_roles(const ArrayContainer& file, const std::string& array) {
  const std::vector<std::string> names = file.dimension_names(array);
  std::vector<std::string> said = names;
  for (std::size_t d = 0; d < names.size(); ++d) {
    const std::string name = lower_case(names[d]);
    if (name == "lon" || name == "longitude") said[d] = "x";
    if (name == "lat" || name == "latitude") said[d] = "y";
    const std::string along = file.coordinates(array, d);
    if (along.empty()) continue;
    if (const std::string axis = axis_said_by(file, along); !axis.empty()) said[d] = axis;
  }
  std::vector<DimensionRole> roles = roles_from(said);
  return roles.empty() ? roles_from(names) : roles;
}

// The conventions of NetCDF, which others use too: coordinates of dimensions, packing attributes.
void describe_plainly(const ArrayContainer& file, const std::string& array, ArrayMeaning& meaning) {
  const std::vector<std::int64_t> shape = file.shape(array);
  meaning.roles = stated_roles(file, array);
  meaning.are_roles_by_place = meaning.roles.empty();
  if (meaning.roles.empty()) meaning.roles = roles_by_place(shape);
  std::vector<AxisCoordinates> coordinates(shape.size());
  for (std::size_t d = 0; d < shape.size(); ++d) {
    const std::string along = file.coordinates(array, d);
    if (along.empty()) continue;
    coordinates[d] = coordinates_in(file, along);
    if (std::ssize(coordinates[d].values) != shape[d]) coordinates[d] = {};
  }
  place_by_coordinates(coordinates, meaning);
  // Microscopes write it (z, y, x).
  const std::vector<double> element = file.numbers(array, "element_size_um");
  if (element.size() != 3) return;
  set_box_axes(
      meaning.header, meaning.header.geometry.origin,
      {stated_spacing(element[2]), stated_spacing(element[1]), stated_spacing(element[0])});
  meaning.header.meaning.length_unit = "µm";
}

}  // namespace

std::span<const ArrayConvention> array_conventions() { return kConventions; }

std::vector<std::string> offered_arrays(const ArrayContainer& file, const VolumeChoice& choice) {
  for (const ArrayConvention& convention : kConventions) {
    std::vector<std::string> offered = convention.arrays(file, choice);
    if (!offered.empty()) return offered;
  }
  return file.arrays();
}

ArrayMeaning meaning_of(const ArrayContainer& file, const std::string& array) {
  for (const ArrayConvention& convention : kConventions) {
    ArrayMeaning meaning{.name = std::string(convention.name),
                         .header = {.values = convention.values}};
    if (convention.describe(file, array, meaning)) return meaning;
  }
  ArrayMeaning meaning{.header = {.values = kWithoutStatements}};
  describe_plainly(file, array, meaning);
  unpack_by_attributes(file, array, meaning);
  return meaning;
}

StoredType unsigned_type(StoredType type) {
  const std::string name(multitetra::name(type));
  return name[0] == 'i' ? stored_type_from("u" + name.substr(1)).value_or(type) : type;
}

namespace {

// Returns the packed number of a value. Attributes that are rounded to floats and binary fractions
// leave it slightly beside the integer that is meant.
double packed_number(double value, double slope, double intercept) {
  const double number = (value - intercept) / slope;
  const double nearest = std::round(number);
  const double rounding =
      1e-6 + std::ldexp(std::abs(value) + std::abs(intercept), -22) / std::abs(slope);
  return std::abs(number - nearest) <= rounding ? nearest : number;
}

// Makes the dimension z that has another name, as "depth" or ".": the nearest one before y and x,
// or behind them if they come in this order.
void name_z(std::vector<DimensionRole>& roles) {
  const auto x = std::find(roles.begin(), roles.end(), DimensionRole::kX);
  const auto y = std::find(roles.begin(), roles.end(), DimensionRole::kY);
  if (x == roles.end() || y == roles.end()) return;
  if (x < y) {
    const auto behind = std::find(y, roles.end(), DimensionRole::kOther);
    if (behind != roles.end()) *behind = DimensionRole::kZ;
    return;
  }
  const auto before = std::find(std::make_reverse_iterator(y), roles.rend(), DimensionRole::kOther);
  if (before != roles.rend()) *before = DimensionRole::kZ;
}

}  // namespace

AxisCoordinates coordinates_in(const ArrayContainer& file, const std::string& along) {
  AxisCoordinates coordinates{.values = file.values(along), .unit = file.text(along, "units")};
  const double factor = file.number(along, "scale_factor", 1);
  const double offset = file.number(along, "add_offset", 0);
  double largest = 0;
  for (double& value : coordinates.values) {
    value = factor * value + offset;
    largest = std::max(largest, std::abs(value));
  }
  if (!coordinates.values.empty() && file.type(along) == StoredType::kF32) {
    coordinates.rounding = std::ldexp(largest, -24);
  }
  return coordinates;
}

std::vector<DimensionRole> roles_from(const std::vector<std::string>& names) {
  std::vector<DimensionRole> roles;
  roles.reserve(names.size());
  for (const std::string& written : names) {
    const std::string name = lower_case(written);
    roles.push_back(name == "x"                        ? DimensionRole::kX
                    : name == "y"                      ? DimensionRole::kY
                    : name == "z"                      ? DimensionRole::kZ
                    : name == "t" || name == "time"    ? DimensionRole::kTime
                    : name == "c" || name == "channel" ? DimensionRole::kChannel
                                                       : DimensionRole::kOther);
  }
  const auto count = [&](DimensionRole role) {
    return std::count(roles.begin(), roles.end(), role);
  };
  if (count(DimensionRole::kZ) == 0) name_z(roles);
  const bool is_complete = count(DimensionRole::kX) == 1 && count(DimensionRole::kY) == 1 &&
                           count(DimensionRole::kZ) <= 1 && count(DimensionRole::kTime) <= 1 &&
                           count(DimensionRole::kChannel) <= 1;
  return is_complete ? roles : std::vector<DimensionRole>();
}

std::vector<DimensionRole> roles_by_place(const std::vector<std::int64_t>& shape) {
  std::size_t rank = shape.size();
  std::vector<DimensionRole> roles(rank, DimensionRole::kOther);
  if (rank >= 4 && shape.back() == 1) roles[--rank] = DimensionRole::kComponent;
  for (std::size_t axis = 0; axis < std::min<std::size_t>(rank, 3); ++axis) {
    roles[rank - 1 - axis] = static_cast<DimensionRole>(axis);
  }
  if (rank >= 4) roles[0] = DimensionRole::kTime;
  if (rank >= 5) roles[1] = DimensionRole::kChannel;
  return roles;
}

void place_by_coordinates(const std::vector<AxisCoordinates>& coordinates, ArrayMeaning& meaning) {
  StatedNumbers origin = kNotStated;
  StatedNumbers steps = kNotStated;
  std::array<std::string, 3> units;
  for (std::size_t d = 0; d < coordinates.size(); ++d) {
    const auto& [values, unit, rounding] = coordinates[d];
    if (meaning.roles[d] == DimensionRole::kTime) set_times(coordinates[d], meaning.times);
    if (values.empty() || meaning.roles[d] > DimensionRole::kZ) continue;
    const auto axis = static_cast<std::size_t>(meaning.roles[d]);
    origin[axis] = values.front();
    units[axis] = unit;
    if (values.size() < 2) continue;
    steps[axis] = even_step(coordinates[d]);
    if (steps[axis]) continue;
    origin[axis].reset();
    units[axis].clear();
    meaning.header.contradictions.push_back(
        {Fact::kSpacing,
         "its coordinates along " + std::string(1, "xyz"[axis]) + " are not evenly spaced"});
  }
  set_box_axes(meaning.header, origin, steps);
  set_units_of_axes(meaning.header, units);
}

void unpack_by_attributes(const ArrayContainer& file, const std::string& array,
                          ArrayMeaning& meaning) {
  ImageHeader& header = meaning.header;
  header.meaning.value_unit = unit_from(file.text(array, "units"));
  const std::vector<double> factor = file.numbers(array, "scale_factor");
  const std::vector<double> offset = file.numbers(array, "add_offset");
  if (!factor.empty()) header.slope = factor[0];
  if (!offset.empty()) header.intercept = offset[0];
  if (!factor.empty() || !offset.empty()) header.values.scaling = Basis::kStated;
  meaning.is_unsigned = lower_case(file.text(array, "_Unsigned")) == "true";
  // Attributes have the stored type: -1 is 255 of unsigned bytes.
  const StoredType type = file.type(array).value_or(StoredType::kF64);
  const double wrap = meaning.is_unsigned ? std::ldexp(1, static_cast<int>(8 * bytes_of(type))) : 0;
  const auto as_stored = [&](double number) { return number < 0 ? number + wrap : number; };
  for (const char* attribute : {"_FillValue", "missing_value"}) {
    for (const double number : file.numbers(array, attribute)) {
      header.missing.push_back(as_stored(number));
    }
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<double> range = file.numbers(array, "valid_range");
  if (range.size() != 2) {
    range = {file.number(array, "valid_min", -kInfinity),
             file.number(array, "valid_max", kInfinity)};
  }
  // By the NetCDF User Guide, floats beside packed integers are a range of unpacked values.
  const bool is_of_values =
      header.values.scaling == Basis::kStated && name(type)[0] != 'f' && header.slope != 0 &&
      (file.has_floats(array, "valid_range") || file.has_floats(array, "valid_min") ||
       file.has_floats(array, "valid_max"));
  for (double& end : range) {
    end = is_of_values ? packed_number(end, header.slope, header.intercept) : as_stored(end);
  }
  if (is_of_values && header.slope < 0) std::swap(range[0], range[1]);
  if (range[0] <= range[1] && (range[0] > -kInfinity || range[1] < kInfinity)) {
    header.valid_range = {range[0], range[1]};
  }
  if (header.has_void()) header.values.missing = Basis::kStated;
}

}  // namespace multitetra
