// Conventions of communities for arrays in a container: what dimensions are, where samples are, and
// what numbers mean. Each is a file in conventions/ with one entry in the table of conventions.cpp.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/volume/formats/arrays/array_container.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

enum class DimensionRole { kX, kY, kZ, kTime, kChannel, kComponent, kOther };

// What a convention says about an array.
struct ArrayMeaning {
  std::string name = {};  // Of the convention, such as "NeXus NXdata".
  // A role for each dimension, slowest first.
  std::vector<DimensionRole> roles = {};
  // No name says what the dimensions are: a first one may be channels rather than times.
  bool are_roles_by_place = false;
  // Geometry, units, scaling and missing values; dims and type are not set.
  ImageHeader header;
  SourceTimes times = {};
  bool is_unsigned = false;  // Integers are unsigned, whatever their type.
  // Slope and intercept: one, or one for each entry of the first dimensions.
  std::vector<std::array<double, 2>> scales = {};
  // The file's geometry is of a kind that is not read.
  bool is_geometry_unread = false;
  bool has_levels = false;  // The array is one of the levels of a pyramid, for --level.
  // Of the image along x, y, z, if the array is padded.
  std::array<std::optional<std::int64_t>, 3> sides = {};
  // Those of which the array is one, for --channel.
  std::vector<SourceField> channels = {};
};

struct ArrayConvention {
  std::string_view name;
  // What is known of values before describe(), which may know more.
  ValueBasis values;
  // Returns the arrays that this convention offers as volumes, none if the file does not follow it.
  std::vector<std::string> (*arrays)(const ArrayContainer& file, const VolumeChoice& choice);
  // Sets what it says about an array; returns false if the array does not follow it.
  bool (*describe)(const ArrayContainer& file, const std::string& array, ArrayMeaning& meaning);
};

[[nodiscard]] std::span<const ArrayConvention> array_conventions();

// Returns the arrays that the conventions offer, or else all arrays.
[[nodiscard]] std::vector<std::string> offered_arrays(const ArrayContainer& file,
                                                      const VolumeChoice& choice);

// Returns what the first convention that an array follows says of it; else what the attributes of
// NetCDF's conventions (CF) and dimension scales say.
[[nodiscard]] ArrayMeaning meaning_of(const ArrayContainer& file, const std::string& array);

// Returns the unsigned type of the same size; floats stay.
[[nodiscard]] StoredType unsigned_type(StoredType type);

// ---- for conventions

// Coordinates along an axis: evenly spaced values, and their unit in the file.
struct AxisCoordinates {
  std::vector<double> values = {};
  std::string unit = {};
  double rounding = 0;  // By how much each value may be rounded.
};

// Returns the coordinates in an array of one dimension, unpacked by scale_factor and add_offset.
[[nodiscard]] AxisCoordinates coordinates_in(const ArrayContainer& file, const std::string& along);

// Returns the roles of dimensions that are named x, y, z (or t, time, c, channel; other names are
// kOther); empty unless x and y occur once each, and z at most once. Without a z, the other name
// next to them is z: "depth", "lev".
[[nodiscard]] std::vector<DimensionRole> roles_from(const std::vector<std::string>& names);

// Returns the roles of unnamed dimensions: the last ones are z, y, x, the first of four or more is
// the time, the second of five the channel; a last dimension of 1 has the numbers of a sample.
[[nodiscard]] std::vector<DimensionRole> roles_by_place(const std::vector<std::int64_t>& shape);

// Places an array by the coordinates along each of its dimensions, in units of their own, according
// to meaning.roles, which must be set. Coordinates that are not evenly spaced are a contradiction.
void place_by_coordinates(const std::vector<AxisCoordinates>& coordinates, ArrayMeaning& meaning);

// Sets scaling, missing values and sign by the attributes of NetCDF: scale_factor, add_offset,
// _FillValue, missing_value, valid_range, valid_min, valid_max, _Unsigned, units.
void unpack_by_attributes(const ArrayContainer& file, const std::string& array,
                          ArrayMeaning& meaning);

}  // namespace multitetra
