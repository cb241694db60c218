#include "server/volume/formats/zarr/zarr_volume.hpp"

#include <algorithm>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/json.hpp"
#include "server/volume/formats/zarr/detail/chunked_array.hpp"
#include "server/volume/formats/zarr/detail/chunked_slices.hpp"
#include "server/volume/formats/zarr/detail/volume_objects.hpp"
#include "server/volume/formats/zarr/detail/zarr_contents.hpp"
#include "server/volume/formats/zarr/detail/zarr_json.hpp"

namespace multitetra {
namespace {

using Json = nlohmann::json;

// The placement of a level of an OME-Zarr image. Vectors are in the order of the dimensions.
struct Placement {
  // Names of dimensions: "t", "c", "z", "y", "x"; empty if unknown.
  std::vector<std::string> names;
  std::vector<std::string> units = {};
  // Absent where the metadata do not state them.
  std::vector<std::optional<double>> scale = {};
  std::vector<std::optional<double>> translation = {};
  std::string value_unit = {};
};

// Some buckets deny access to missing objects. Detects this by a name that cannot exist; only then
// does denied access to metadata mean that they are missing.
bool refuses_what_is_missing(ObjectStore& store) {
  try {
    return text_of(store, "multitetra/nonexistent").has_value();
  } catch (const InaccessibleObject&) {
    return true;
  }
}

std::optional<std::string> metadata_at(ObjectStore& store, const std::string& key) {
  try {
    return text_of(store, key);
  } catch (const InaccessibleObject&) {
    if (refuses_what_is_missing(store)) return std::nullopt;
    throw;
  }
}

Json json_at(ObjectStore& store, const std::string& key) {
  const std::optional<std::string> text = metadata_at(store, key);
  if (!text) return {};
  Json json = parse_zarr_json(*text);
  if (json.is_discarded()) {
    fail_reading(store.place(key), "it is not JSON", "Get a complete copy of the array");
  }
  return json;
}

// Returns the folder's user attributes: from zarr.json (Zarr 3), .zattrs (Zarr 2) or
// attributes.json (N5).
Json attributes_at(ObjectStore& store, const std::string& path) {
  const Json three = json_at(store, path + "zarr.json");
  if (three.is_object()) return three.value("attributes", Json::object());
  const Json two = json_at(store, path + ".zattrs");
  if (two.is_object()) return two;
  return json_at(store, path + "attributes.json");
}

std::optional<ArrayLayout> array_at(ObjectStore& store, const std::string& path) {
  const auto parsed = [&](const std::string& key, const auto& parse) -> std::optional<ArrayLayout> {
    const std::optional<std::string> text = metadata_at(store, key);
    if (!text) return std::nullopt;
    auto layout = parse(*text);
    if (layout) return *std::move(layout);
    fail_reading(store.place(key), layout.error().text, "Save the array in another way");
  };
  const Json three = json_at(store, path + "zarr.json");
  if (three.is_object() && three.value("node_type", Json()) == "array") {
    return parsed(path + "zarr.json", parse_zarr_3);
  }
  if (auto layout = parsed(path + ".zarray", parse_zarr_2)) return layout;
  const Json n5 = json_at(store, path + "attributes.json");
  if (n5.is_object() && n5.contains("dimensions"))
    return parsed(path + "attributes.json", parse_n5);
  return std::nullopt;
}

// Applies a list of scales and translations.
void apply(const Json& transformations, Placement& placement, const std::filesystem::path& place) {
  if (!transformations.is_array()) return;
  const std::size_t dimensions = placement.scale.size();
  for (const Json& transformation : transformations) {
    const Json type = transformation.value("type", Json());
    if (type == "identity") continue;
    const bool is_scale = type == "scale";
    const Json numbers = transformation.value(is_scale ? "scale" : "translation", Json());
    if ((!is_scale && type != "translation") || !numbers.is_array() ||
        numbers.size() != dimensions ||
        !std::all_of(numbers.begin(), numbers.end(), [](const Json& x) { return x.is_number(); })) {
      fail_reading(
          place,
          "its coordinateTransformations have an entry that is not a scale or translation of " +
              std::to_string(dimensions) + " numbers",
          "Correct its metadata");
    }
    for (std::size_t d = 0; d < dimensions; ++d) {
      const double number = numbers[d].get<double>();
      std::optional<double>& scale = placement.scale[d];
      std::optional<double>& translation = placement.translation[d];
      if (is_scale) {
        scale = scale.value_or(1) * number;
        if (translation) *translation *= number;
      } else {
        translation = translation.value_or(0) + number;
      }
    }
  }
}

struct ImageLevel {
  std::string path;
  Placement placement;
};

// Returns the chosen level of an image with these attributes; nullopt if they describe no image.
std::optional<ImageLevel> image_level(const Json& attributes, const VolumeChoice& choice,
                                      const std::filesystem::path& place) {
  const Json& ome = attributes.contains("ome") ? attributes.at("ome") : attributes;
  if (!ome.is_object() || !ome.contains("multiscales")) return std::nullopt;
  const Json image = ome.at("multiscales").is_array() && !ome.at("multiscales").empty()
                         ? ome.at("multiscales")[0]
                         : Json();
  const Json levels = image.is_object() ? image.value("datasets", Json()) : Json();
  const std::int64_t level = choice.level.value_or(0);
  if (!levels.is_array() || level < 0 || level >= static_cast<std::int64_t>(levels.size())) {
    fail_reading(place,
                 "it has " + std::to_string(levels.is_array() ? levels.size() : 0) +
                     " levels, but no level " + std::to_string(level),
                 "Choose one with --level; 0 is the finest");
  }
  const Json& chosen = levels[static_cast<std::size_t>(level)];
  ImageLevel result;
  result.path = chosen.value("path", std::string());
  for (const Json& axis : image.value("axes", Json::array())) {
    const bool is_object = axis.is_object();
    result.placement.names.push_back(is_object          ? axis.value("name", std::string())
                                     : axis.is_string() ? axis.get<std::string>()
                                                        : std::string());
    result.placement.units.push_back(is_object ? axis.value("unit", std::string()) : std::string());
  }
  if (result.placement.names.size() > 8)
    fail_reading(place, "it has too many axes", "Correct its metadata");
  result.placement.scale.resize(result.placement.names.size());
  result.placement.translation.resize(result.placement.names.size());
  apply(chosen.value("coordinateTransformations", Json()), result.placement, place);
  apply(image.value("coordinateTransformations", Json()), result.placement, place);
  return result;
}

// Returns the placement of a plain array, by the conventions of programs that write them.
Placement placement_of(const ArrayLayout& array, const Json& attributes) {
  Placement placement{.names = array.dimension_names};
  const std::size_t dimensions = array.shape.size();
  placement.scale.resize(dimensions);
  placement.translation.resize(dimensions);
  if (!attributes.is_object()) return placement;
  const Json unit = attributes.value("units", Json());
  if (unit.is_string()) placement.value_unit = unit.get<std::string>();
  // xarray names dimensions this way; N5 viewers store a resolution in the order of N5.
  const Json names = attributes.value("_ARRAY_DIMENSIONS", Json());
  if (names.is_array() && names.size() == dimensions) {
    placement.names.clear();
    for (const Json& name : names)
      placement.names.push_back(name.is_string() ? name.get<std::string>() : "");
  }
  const Json resolution =
      attributes.value("pixelResolution", attributes.value("resolution", Json()));
  const Json steps = resolution.is_object() ? resolution.value("dimensions", Json()) : resolution;
  if (array.key_is_reversed && steps.is_array() && steps.size() == dimensions &&
      std::all_of(steps.begin(), steps.end(), [](const Json& x) { return x.is_number(); })) {
    for (std::size_t d = 0; d < dimensions; ++d) {
      placement.scale[d] = steps[dimensions - 1 - d].get<double>();
    }
    const std::string length_unit =
        resolution.is_object() ? resolution.value("unit", std::string()) : std::string();
    placement.units.assign(dimensions, length_unit);
    // Neuroglancer stores units beside the resolution: one, or one per dimension.
    if (unit.is_string() && length_unit.empty()) {
      placement.units.assign(dimensions, unit.get<std::string>());
      placement.value_unit.clear();
    }
    for (std::size_t d = 0; unit.is_array() && unit.size() == dimensions && d < dimensions; ++d) {
      const Json& own = unit[dimensions - 1 - d];
      if (own.is_string()) placement.units[d] = own.get<std::string>();
    }
  }
  return placement;
}

SourceTimes times_along(const Placement& placement, std::size_t d, std::int64_t count) {
  const bool has_unit = d < placement.units.size() && !placement.units[d].empty();
  if (d >= placement.scale.size() || !placement.scale[d] || !has_unit) {
    return {.count = count};  // A scale without a unit is no time.
  }
  return even_times(count, placement.translation[d].value_or(0), *placement.scale[d],
                    placement.units[d]);
}

// Selects the dimensions x, y, z, and the position of the volume along the others. Adds times,
// channels and the chosen channel's window to `stored`.
VolumeInArray volume_in(const ArrayLayout& array, const Placement& placement,
                        const VolumeChoice& choice, const std::filesystem::path& place,
                        const Json& attributes, StoredVolume& stored) {
  const std::size_t dimensions = array.shape.size();
  if (dimensions < 2) fail_reading(place, "it has one dimension", "Give an array of 2 or more");
  const std::vector<std::string>& names = placement.names;
  VolumeInArray volume{.axes = {}, .at = std::vector<std::int64_t>(dimensions, 0)};
  const bool named = names.size() == dimensions &&
                     std::count(names.begin(), names.end(), "x") == 1 &&
                     std::count(names.begin(), names.end(), "y") == 1 &&
                     std::count(names.begin(), names.end(), "z") <= 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (named) {
      const auto found = std::find(names.begin(), names.end(), std::string(1, "xyz"[axis]));
      if (found != names.end()) volume.axes[axis] = static_cast<std::size_t>(found - names.begin());
    } else if (axis < dimensions) {
      volume.axes[axis] = dimensions - 1 - axis;
    }
  }
  std::int64_t channel = 0;
  for (std::size_t d = 0; d < dimensions; ++d) {
    if (std::find(volume.axes.begin(), volume.axes.end(), d) != volume.axes.end()) continue;
    const std::string name = names.size() == dimensions ? names[d] : std::string();
    // Without names, image arrays are in the order time, channel, z, y, x.
    const bool is_time = name.empty() ? dimensions == 5 && d == 0 : name == "t" || name == "time";
    const bool is_channel = name.empty() ? d + 4 == dimensions : name == "c" || name == "channel";
    std::optional<std::int64_t> chosen;
    if (is_time) chosen = choice.time;
    if (is_channel) chosen = choice.channel;
    if (is_time) stored.contents.times = times_along(placement, d, array.shape[d]);
    if (is_channel) stored.channels = array.shape[d];
    if (is_channel && array.shape[d] > 1)
      stored.contents.fields = zarr_channels(attributes, array.shape[d]);
    const FileEntries entries = {.count = array.shape[d],
                                 .several = "its dimension " + std::to_string(d + 1) +
                                            (name.empty() ? "" : " (" + name + ")") + " has " +
                                            std::to_string(array.shape[d]) + " entries",
                                 .remedy = is_time      ? kChooseTime
                                           : is_channel ? kChooseChannel
                                                        : "Give an array of three dimensions",
                                 .missing = is_time ? "it has no time" : "it has no channel"};
    volume.at[d] = chosen_entry(place, entries, chosen, choice.first && (is_time || is_channel));
    if (is_channel) channel = volume.at[d];
  }
  stored.contents.display_window = zarr_window(attributes, channel, place, stored.notices);
  return volume;
}

ImageHeader header_of(const ArrayLayout& array, const Placement& placement,
                      const VolumeInArray& volume, const std::filesystem::path& place) {
  ImageHeader header{.type = array.type};
  StatedNumbers origin = kNotStated;
  StatedNumbers spacing = kNotStated;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto d = volume.axes[axis];
    if (!d) continue;
    header.dims[axis] = array.shape[*d];
    if (*d < placement.scale.size()) {
      spacing[axis] = placement.scale[*d];
      origin[axis] = placement.translation[*d];
    }
    if (*d >= placement.units.size() || placement.units[*d].empty()) continue;
    const std::string unit = unit_from(placement.units[*d]);
    if (axis > 0 && !header.meaning.length_unit.empty() && unit != header.meaning.length_unit) {
      fail_reading(place,
                   "its axes have different units, " + header.meaning.length_unit + " and " + unit,
                   "Correct its metadata");
    }
    header.meaning.length_unit = unit;
  }
  header.meaning.value_unit = unit_from(placement.value_unit);
  set_box_axes(header, origin, spacing);
  check_header(place, header);
  return header;
}

StoredVolume open_checked(std::shared_ptr<ObjectStore> store, const VolumeChoice& choice) {
  std::string path = choice.array;
  if (!path.empty() && !path.ends_with('/')) path += '/';
  std::optional<ArrayLayout> array = array_at(*store, path);
  const Json attributes = attributes_at(*store, path);
  std::optional<ImageLevel> image;
  if (array && choice.level) {
    fail_reading(store->place(path), "--level does not apply: it is one array without levels",
                 "Omit --level");
  }
  if (!array) {
    image = image_level(attributes, choice, store->place(path));
    if (!image) {
      fail_reading(store->place(path), "it has no array and no OME-Zarr image",
                   "Select an array inside with --array");
    }
    path += image->path;
    if (!path.empty() && !path.ends_with('/')) path += '/';
    array = array_at(*store, path);
    if (!array) fail_damaged(store->place(path), "the level's array is missing");
  }
  const std::filesystem::path place = store->place(path);
  Placement placement = image ? std::move(image->placement) : placement_of(*array, attributes);
  if (image && placement.names.empty()) {  // From before axes had names: always t, c, z, y, x.
    placement.names = {"t", "c", "z", "y", "x"};
    placement.scale.resize(5);
    placement.translation.resize(5);
  }
  if (image && placement.names.size() != array->shape.size()) {
    fail_reading(place,
                 "the image has " + std::to_string(placement.names.size()) +
                     " axes, but the array has " + std::to_string(array->shape.size()) +
                     " dimensions",
                 "Correct its metadata");
  }
  StoredVolume stored{.contents = {.labels = zarr_labels(attributes)}};
  VolumeInArray volume = volume_in(*array, placement, choice, place, attributes, stored);
  stored.header = header_of(*array, placement, volume, place);
  stored.slices = chunked_slices(std::move(store), path, *std::move(array), std::move(volume));
  return stored;
}

bool has_metadata(ObjectStore& store) {
  std::exception_ptr refusal;
  for (const char* key : {"zarr.json", ".zarray", ".zgroup", ".zattrs", "attributes.json"}) {
    try {
      if (text_of(store, key)) return true;
    } catch (const InaccessibleObject&) {
      if (!refusal) refusal = std::current_exception();
    }
  }
  if (refusal) std::rethrow_exception(refusal);
  return false;
}

}  // namespace

bool is_zarr(const std::string& place, bool allow_external_files) {
  return has_metadata(*volume_objects(place, allow_external_files));
}

StoredVolume open_zarr(const std::string& place, const VolumeChoice& choice) {
  std::shared_ptr<ObjectStore> store = volume_objects(place, choice.allow_external_files);
  if (!has_metadata(*store)) {
    fail_reading(place,
                 "there is no zarr.json, .zattrs, .zgroup, .zarray or attributes.json below it",
                 "Give the address of an OME-Zarr image or of a Zarr or N5 array, and the required "
                 "credentials");
  }
  const std::filesystem::path array = store->place(choice.array);
  try {
    return open_checked(std::move(store), choice);
  } catch (const Json::exception& problem) {  // A field has an unexpected type.
    fail_damaged(array, std::string("its metadata are damaged: ") + problem.what());
  }
}

}  // namespace multitetra
