#include "server/volume/formats/zarr/zarr_volume.hpp"

#include <algorithm>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "common/base/json.hpp"
#include "server/store/http_store.hpp"
#include "server/volume/formats/arrays/array_volume.hpp"
#include "server/volume/formats/detail/zip_store.hpp"
#include "server/volume/formats/zarr/detail/chunked_slices.hpp"
#include "server/volume/formats/zarr/detail/n5_placement.hpp"
#include "server/volume/formats/zarr/detail/ome_image.hpp"
#include "server/volume/formats/zarr/detail/zarr_container.hpp"
#include "server/volume/formats/zarr/detail/zarr_contents.hpp"

namespace multitetra {
namespace {

using Json = nlohmann::json;

// Returns the group or array to open: choice.array, or the only image or array below the root.
std::string chosen_path(const ZarrContainer& file, const VolumeChoice& choice,
                        VolumeContents& contents) {
  const std::string& path = choice.array;
  const Json& attributes = file.attributes(path);
  const bool is_image = attributes.is_object() && ome_level(attributes, choice, file.file());
  if (is_image || file.layout(path)) return path;
  std::vector<std::string> found = ome_images(file, path);
  const std::string kind = found.empty() ? "array" : "image";
  if (found.empty() && path.empty()) found = offered_arrays(file, choice);
  for (std::string& name : found) {
    if (found.size() > 1) {
      contents.entries.push_back(
          {.kind = kind, .name = name, .detail = {}, .option = "--array " + name});
    }
  }
  if (found.size() == 1 || (choice.first && !found.empty())) return found.front();
  if (found.empty() && !file.unsupported().empty()) throw VolumeFileError(file.unsupported());
  std::string list;
  for (const std::string& name : found) {
    if (list.size() < 600) list += (list.empty() ? "" : ", ") + name;
  }
  fail_reading(file.store()->place(path),
               found.empty() ? "it has no array and no OME-Zarr image"
                             : "it has " + std::to_string(found.size()) + " " + kind + "s: " + list,
               "Select one inside with --array");
}

// What an image states, or the conventions of its array.
ArrayMeaning meaning_in_zarr(const ZarrContainer& file, const std::string& array,
                             const ArrayLayout& layout, std::optional<ArrayMeaning> of_image) {
  const std::size_t rank = layout.shape.size();
  if (!of_image) {
    ArrayMeaning meaning = meaning_of(file, array);
    if (layout.fill_is_missing && meaning.header.missing.empty() &&
        !file.texts(array, "_ARRAY_DIMENSIONS").empty()) {
      meaning.header.missing.push_back(number_from(layout.type, layout.fill.data()));
      meaning.header.values.missing = Basis::kStated;
    }
    if (!layout.key_is_reversed || meaning.name == "BigDataViewer") return meaning;
    place_n5(file, array, meaning);
    meaning.header.meaning.value_unit.clear();  // N5 has the units of lengths under this name.
    return meaning;
  }
  if (of_image->roles.size() != rank) {
    fail_reading(file.store()->place(array),
                 "the image has " + std::to_string(of_image->roles.size()) +
                     " axes, but the array has " + std::to_string(rank) + " dimensions",
                 "Correct its metadata");
  }
  for (std::size_t d = 0; d < rank; ++d) {
    if (of_image->roles[d] != DimensionRole::kTime || of_image->times.at.size() != 2) continue;
    const auto [first, step] = std::pair(of_image->times.at[0], of_image->times.at[1]);
    of_image->times = even_times(layout.shape[d], first, step, of_image->times.unit);
  }
  return *std::move(of_image);
}

StoredVolume open_checked(std::shared_ptr<ObjectStore> store, const VolumeChoice& choice) {
  ZarrContainer file(store);
  file.described_by = choice.described_by;
  VolumeContents contents;
  std::string path = chosen_path(file, choice, contents);
  const Json attributes = file.attributes(path);
  std::optional<ArrayMeaning> of_image;
  std::vector<std::string> images;
  if (!file.layout(path)) {
    std::optional<OmeLevel> level = ome_level(attributes, choice, store->place(path));
    images = std::move(level.value().images);
    path = key_prefix_of(path) + level.value().path;
    of_image = std::move(level->meaning);
  }
  std::optional<ArrayLayout> layout = file.layout(path);
  if (!layout) fail_incomplete(store->place(path), "the level's array is missing");
  if (layout->shape.size() < 2) {
    fail_reading(store->place(path), "it has one dimension", "Give an array of 2 or more");
  }
  ArrayMeaning meaning = meaning_in_zarr(file, path, *layout, std::move(of_image));
  if (choice.level && !meaning.has_levels) {
    fail_reading(store->place(path), "--level does not apply: it is one array without levels",
                 "Omit --level");
  }
  const std::vector<DimensionRole> roles = meaning.roles;
  VolumeInArray place;
  StoredVolume stored =
      described_volume(file, path, std::move(meaning), choice, /*has_components=*/false, place);
  stored.contents.labels = zarr_labels(attributes);
  stored.contents.entries = std::move(contents.entries);
  offer_images(file.file(), "image", images, choice, stored);
  const auto channel_at = std::find(roles.begin(), roles.end(), DimensionRole::kChannel);
  std::int64_t channel = 0;
  if (channel_at != roles.end())
    channel = place.at[static_cast<std::size_t>(channel_at - roles.begin())];
  if (stored.channels > 1) stored.contents.fields = zarr_channels(attributes, stored.channels);
  stored.contents.display_window =
      zarr_window(attributes, channel, store->place(path), stored.notices);
  layout->type = place.type;
  stored.slices = chunked_slices(std::move(store), key_prefix_of(path), *std::move(layout),
                                 {.axes = place.axes, .at = place.at});
  return stored;
}

// Opens the files below a folder, in a zip archive, or below an address.
std::shared_ptr<ObjectStore> objects_of(const std::string& place, bool allow_external_files) {
  if (is_address(place)) return http_store(place, {.allow_other_hosts = allow_external_files});
  std::error_code error;
  if (std::filesystem::is_directory(place, error)) return folder_store(place, allow_external_files);
  return zip_store(place);
}

bool has_metadata(ObjectStore& store) {
  std::exception_ptr refusal;
  for (const char* key : {"zarr.json", ".zarray", ".zgroup", ".zattrs", "attributes.json"}) {
    try {
      if (text_of(store, key)) return true;
    } catch (const StoreAccessDenied&) {
      if (!refusal) refusal = std::current_exception();
    }
  }
  if (refusal) std::rethrow_exception(refusal);
  return false;
}

}  // namespace

bool is_zarr(const std::string& place, bool allow_external_files) {
  try {
    return has_metadata(*objects_of(place, allow_external_files));
  } catch (const StoreError& problem) {
    throw VolumeFileError(problem.what());
  }
}

StoredVolume open_zarr(const std::string& place, const VolumeChoice& choice) {
  try {
    std::shared_ptr<ObjectStore> store = objects_of(place, choice.allow_external_files);
    if (has_metadata(*store)) return open_checked(std::move(store), choice);
  } catch (const Json::exception& problem) {  // A field has an unexpected type.
    fail_damaged(
        std::filesystem::path(place) / choice.array,
        std::string("a field of its metadata has another type than expected: ") + problem.what());
  } catch (const StoreError& problem) {
    throw VolumeFileError(problem.what());
  }
  fail_reading(place,
               "there is no zarr.json, .zattrs, .zgroup, .zarray or attributes.json below it",
               "Give the address of an OME-Zarr image or of a Zarr or N5 array, and the required "
               "credentials");
}

}  // namespace multitetra
