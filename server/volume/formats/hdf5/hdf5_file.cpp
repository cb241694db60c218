#include "server/volume/formats/hdf5/hdf5_file.hpp"

#include <hdf5_hl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/volume/formats/detail/axis_coordinates.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/hdf5/detail/hdf5_chunks.hpp"
#include "server/volume/formats/hdf5/detail/hdf5_lzf.hpp"
#include "server/volume/formats/hdf5/detail/hdf5_object.hpp"
#include "server/volume/formats/hdf5/detail/imaris_volume.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxDatasets = 10'000;

std::optional<StoredType> type_of_dataset(hid_t dataset) {
  const Hdf5Id type(H5Dget_type(dataset), &H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.get());
  const std::size_t bytes = H5Tget_size(type.get());
  if (kind == H5T_FLOAT) {
    if (bytes <= 4) return StoredType::kF32;
    return bytes == 8 ? std::optional(StoredType::kF64) : std::nullopt;
  }
  if (kind == H5T_ENUM && bytes == 1) return StoredType::kI8;  // h5py's booleans.
  if (kind != H5T_INTEGER) return std::nullopt;
  const bool is_signed = H5Tget_sign(type.get()) != H5T_SGN_NONE;
  return stored_type_from((is_signed ? "i" : "u") + std::to_string(8 * bytes));
}

hid_t memory_type(StoredType type) {
  const std::array<hid_t, 10> types = {
      H5T_NATIVE_UINT8,  H5T_NATIVE_INT8,  H5T_NATIVE_UINT16, H5T_NATIVE_INT16, H5T_NATIVE_FLOAT,
      H5T_NATIVE_UINT32, H5T_NATIVE_INT32, H5T_NATIVE_UINT64, H5T_NATIVE_INT64, H5T_NATIVE_DOUBLE};
  return types[static_cast<std::size_t>(type)];
}

// ---- choosing the dataset

struct FoundDatasets {
  std::vector<std::string> names;
};

#if H5_VERSION_GE(1, 12, 0)
using ObjectInfo = H5O_info1_t;  // What H5Ovisit2 passes; 1.12 gave the old name to another type.
#else
using ObjectInfo = H5O_info_t;
#endif

herr_t note_dataset(hid_t group, const char* name, const ObjectInfo* info, void* found) {
  if (info->type != H5O_TYPE_DATASET) return 0;
  auto& names = static_cast<FoundDatasets*>(found)->names;
  if (names.size() >= kMaxDatasets) return 1;
  const Hdf5Id dataset(H5Dopen2(group, name, H5P_DEFAULT), &H5Dclose);
  if (!dataset) return 0;
  std::size_t sides = 0;
  for (const hsize_t length : hdf5_dims(dataset.get())) sides += length > 1;
  if (sides >= 2 && type_of_dataset(dataset.get())) names.emplace_back(std::string("/") + name);
  return 0;
}

FoundDatasets datasets_in(hid_t file) {
  FoundDatasets found;
  H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_NATIVE, &note_dataset, &found, H5O_INFO_BASIC);
  return found;
}

std::vector<hsize_t> dims_of_dataset(hid_t file, const std::string& name) {
  const Hdf5Id dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT), &H5Dclose);
  return dataset ? hdf5_dims(dataset.get()) : std::vector<hsize_t>();
}

// Returns the dataset with the most samples; the first of several.
std::string largest_dataset(hid_t file, const std::vector<std::string>& names) {
  const auto samples = [&](const std::string& name) {
    double product = 1;
    for (const hsize_t length : dims_of_dataset(file, name)) product *= static_cast<double>(length);
    return product;
  };
  return *std::max_element(names.begin(), names.end(),
                           [&](const auto& a, const auto& b) { return samples(a) < samples(b); });
}

// Adds the datasets with the shape of the chosen one, named by the last component of their path if
// that is unique.
void add_fields_of_shape(hid_t file, const std::vector<hsize_t>& dims, VolumeContents& contents) {
  std::vector<std::string> names;
  std::map<std::string, int> uses;
  for (const std::string& name : datasets_in(file).names) {
    if (dims_of_dataset(file, name) != dims) continue;
    names.push_back(name);
    ++uses[name.substr(name.rfind('/') + 1)];
  }
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) {
    const std::string last = name.substr(name.rfind('/') + 1);
    const std::string name_of_field = member_name_from(uses[last] == 1 ? last : name.substr(1));
    if (name_of_field.empty()) {
      contents.unnamed.push_back(name);
    } else {
      contents.fields.push_back({.name = name_of_field, .array = name});
    }
  }
}

std::string chosen_dataset(const fs::path& path, hid_t file, const VolumeChoice& choice) {
  if (!choice.array.empty()) return choice.array;
  const FoundDatasets found = datasets_in(file);
  if (found.names.size() == 1) return found.names.front();
  if (choice.first && !found.names.empty()) return largest_dataset(file, found.names);
  std::string list;
  for (const std::string& name : found.names) {
    if (list.size() < 600) list += (list.empty() ? "" : ", ") + name;
  }
  fail_reading(path,
               found.names.empty()
                   ? "it has no dataset of numbers with two or more dimensions"
                   : "it has " + std::to_string(found.names.size()) + " datasets: " + list,
               "Give one, as in '" + path.filename().string() +
                   ":/path', or prepare several of "
                   "one shape with --field");
}

// ---- its placement

struct ReadScale {
  fs::path file;
  AxisCoordinates coordinates = {};
  // Exceptions may not pass libhdf5.
  std::exception_ptr failure = {};
};

herr_t read_scale(hid_t, unsigned, hid_t scale, void* into) {
  auto& result = *static_cast<ReadScale*>(into);
  try {
    const std::vector<hsize_t> dims = hdf5_dims(scale);
    if (dims.size() != 1 || dims[0] < 1 || dims[0] > static_cast<hsize_t>(kMaxSide)) return 1;
    const Hdf5Id creation(H5Dget_create_plist(scale), &H5Pclose);
    const bool is_elsewhere =
        H5Pget_external_count(creation.get()) > 0 || H5Pget_layout(creation.get()) == H5D_VIRTUAL;
    if (is_elsewhere) return 1;  // Ignores scales in other files.
    Hdf5ChunkSizes(result.file, scale, false).require_whole(scale, whole_box(dims));
    std::vector<double>& values = result.coordinates.values;
    values.resize(dims[0]);
    if (H5Dread(scale, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
      values.clear();
    result.coordinates.unit = hdf5_text(scale, "units");
  } catch (...) {
    result.failure = std::current_exception();
  }
  return 1;
}

// Returns the first scale of a dimension; without values if there is none.
AxisCoordinates scale_of(const fs::path& path, hid_t dataset, unsigned dimension) {
  ReadScale scale{.file = path};
  if (H5DSget_num_scales(dataset, dimension) <= 0) return {};
  H5DSiterate_scales(dataset, dimension, nullptr, &read_scale, &scale);
  if (scale.failure) std::rethrow_exception(scale.failure);
  return std::move(scale.coordinates);
}

void place_volume(const fs::path& path, hid_t dataset, std::size_t rank, ImageHeader& header,
                  std::vector<std::string>& notices) {
  const std::size_t axes = std::min<std::size_t>(rank, 3);
  std::array<AxisCoordinates, 3> coordinates;
  const std::vector<double> element = hdf5_numbers(dataset, "element_size_um", 3);
  for (std::size_t axis = 0; axis < axes; ++axis) {
    AxisCoordinates& scale = coordinates[axis];
    if (element.size() == 3 && element[2 - axis] > 0) {
      scale.step = element[2 - axis];
      scale.unit = "um";
      continue;
    }
    scale = scale_of(path, dataset, static_cast<unsigned>(rank - 1 - axis));
    const bool is_whole = scale.values.size() == static_cast<std::size_t>(header.dims[axis]);
    if (!is_whole || scale.values.size() < 2) scale = {};
  }
  place_by_coordinates(path, coordinates, axes, header, notices);
}

// Returns the times from the scale of the first dimension.
SourceTimes times_along(const fs::path& path, hid_t dataset, hsize_t count) {
  SourceTimes times{.count = static_cast<std::int64_t>(std::min<hsize_t>(count, hsize_t{1} << 62))};
  if (count < 2) return times;
  AxisCoordinates scale = scale_of(path, dataset, 0);
  const bool are_times =
      scale.values.size() == count && std::all_of(scale.values.begin(), scale.values.end(),
                                                  [](double t) { return std::isfinite(t); });
  if (!are_times) return times;
  times.at = std::move(scale.values);
  times.unit = time_unit_from(scale.unit);
  return times;
}

// Returns the position of the volume along the dimensions before z, y, x.
std::vector<hsize_t> leading_indices(const fs::path& path, const std::vector<hsize_t>& dims,
                                     const VolumeChoice& choice, hid_t dataset, SourceTimes& times,
                                     std::int64_t& channels) {
  std::vector<hsize_t> at(dims.size(), 0);
  if (dims.size() <= 3) return at;
  const std::size_t others = dims.size() - 3;
  for (std::size_t d = 0; d < others; ++d) {
    // Time comes first; if there are two, the one before z is the channel.
    const bool is_channel = d > 0 || (others == 1 && choice.channel);
    std::optional<std::int64_t> chosen;
    if (d <= 1) chosen = is_channel ? choice.channel : choice.time;
    if (d <= 1 && is_channel) channels = static_cast<std::int64_t>(dims[d]);
    if (d == 0 && !is_channel) times = times_along(path, dataset, dims[d]);
    const std::string dimension = "its dimension " + std::to_string(d + 1);
    const FileEntries entries = {
        .count = static_cast<std::int64_t>(std::min<hsize_t>(dims[d], hsize_t{1} << 62)),
        .several = dimension + " has " + std::to_string(dims[d]) + " entries",
        .remedy = d > 1 ? "Give a dataset of at most five dimensions"
                        : "Choose one with --time or --channel, from 0, or prepare all with "
                          "--all-times",
        .missing = dimension + " has no entry"};
    at[d] = static_cast<hsize_t>(chosen_entry(path, entries, chosen, choice.first && d <= 1));
  }
  return at;
}

class Hdf5Slices : public StoredSlices {
 public:
  Hdf5Slices(fs::path path, Hdf5Id file, Hdf5Id dataset, std::vector<hsize_t> at,
             std::vector<hsize_t> dims, StoredType type, bool allow_external_files)
      : path_(std::move(path)),
        file_(std::move(file)),
        dataset_(std::move(dataset)),
        at_(std::move(at)),
        dims_(std::move(dims)),
        type_(type),
        chunk_sizes_(path_, dataset_.get(), allow_external_files) {}

  void read(std::size_t first, std::size_t count, std::byte* into) override {
    const std::size_t rank = dims_.size();
    Hdf5Box box{.start = at_, .extent = std::vector<hsize_t>(rank, 1)};
    auto& [start, extent] = box;
    extent[rank - 1] = dims_[rank - 1];
    extent[rank - 2] = dims_[rank - 2];
    if (rank >= 3) {
      start[rank - 3] = first;
      extent[rank - 3] = count;
    }
    chunk_sizes_.require_whole(dataset_.get(), box);
    const Hdf5Id space(H5Dget_space(dataset_.get()), &H5Sclose);
    const Hdf5Id memory(H5Screate_simple(static_cast<int>(rank), extent.data(), nullptr),
                        &H5Sclose);
    H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr);
    if (H5Dread(dataset_.get(), memory_type(type_), memory.get(), space.get(), H5P_DEFAULT, into) >=
        0)
      return;
    fail_reading(
        path_, "its slices from " + std::to_string(first) + " on cannot be read",
        "Get a complete copy of the file; chunks must be compressed with deflate, szip or LZF");
  }

 private:
  fs::path path_;
  Hdf5Id file_;
  Hdf5Id dataset_;
  std::vector<hsize_t> at_;
  std::vector<hsize_t> dims_;
  StoredType type_;
  Hdf5ChunkSizes chunk_sizes_;
};

}  // namespace

bool is_hdf5(std::string_view beginning) {
  for (const std::size_t at : {0u, 512u, 1024u, 2048u}) {  // Other data may precede the signature.
    if (beginning.size() > at && beginning.substr(at).starts_with("\x89HDF\r\n\x1a\n")) return true;
  }
  return false;
}

StoredVolume open_hdf5(const fs::path& path, const VolumeChoice& choice) {
  register_hdf5_lzf();
  Hdf5Id file = open_hdf5_file(path);
  const std::optional<ImarisVolume> imaris = imaris_volume(path, file.get(), choice);
  if (!imaris && choice.level) {
    fail_reading(path, "--level does not apply: the file has no resolution levels", "Omit --level");
  }
  const std::string name = imaris ? imaris->dataset : chosen_dataset(path, file.get(), choice);
  std::optional<Hdf5Id> found =
      open_hdf5_dataset(path, file.get(), name, choice.allow_external_files);
  if (!found)
    fail_reading(path, "it has no dataset '" + name + "'", "Check the path inside the file");
  Hdf5Id dataset = *std::move(found);
  const std::optional<StoredType> type = type_of_dataset(dataset.get());
  std::vector<hsize_t> dims = hdf5_dims(dataset.get());
  if (!type || dims.size() < 2 || dims.size() > 8) {
    fail_reading(path,
                 "its dataset '" + name + "' is not an array of numbers with 2 to 5 dimensions",
                 "Choose another dataset");
  }
  StoredVolume volume{.header = {.type = *type}, .slices = nullptr};
  ImageHeader& header = volume.header;
  for (std::size_t axis = 0; axis < std::min<std::size_t>(dims.size(), 3); ++axis) {
    hsize_t& length = dims[dims.size() - 1 - axis];
    if (length > static_cast<hsize_t>(kMaxSide)) {
      fail_reading(
          path, "a side of its dataset '" + name + "' has " + std::to_string(length) + " samples",
          "Each side must have 1 to " + std::to_string(kMaxSide) + " samples");
    }
    if (imaris) length = static_cast<hsize_t>(imaris->dims[axis]);
    header.dims[axis] = static_cast<std::int64_t>(length);
  }
  if (imaris) {
    set_box_axes(header, imaris->origin, imaris->spacing);
    header.meaning.length_unit = imaris->unit;
    volume.contents = imaris->contents;
    volume.channels = std::max<std::int64_t>(1, std::ssize(volume.contents.fields));
  } else {
    place_volume(path, dataset.get(), dims.size(), header, volume.notices);
  }
  header.meaning.value_unit = unit_from(hdf5_text(dataset.get(), "units"));
  const std::vector<double> slope = hdf5_numbers(dataset.get(), "scale_factor", 1);
  const std::vector<double> offset = hdf5_numbers(dataset.get(), "add_offset", 1);
  if (!slope.empty()) header.slope = slope[0];
  if (!offset.empty()) header.intercept = offset[0];
  const std::vector<double> fill = hdf5_numbers(dataset.get(), "_FillValue", 1);
  if (!fill.empty()) header.missing = fill;
  check_header(path, header);
  std::vector<hsize_t> at(dims.size(), 0);
  if (!imaris) {
    at = leading_indices(path, dims, choice, dataset.get(), volume.contents.times, volume.channels);
    if (choice.first) add_fields_of_shape(file.get(), dims, volume.contents);
  }
  volume.slices =
      std::make_unique<Hdf5Slices>(path, std::move(file), std::move(dataset), std::move(at), dims,
                                   *type, choice.allow_external_files);
  return volume;
}

}  // namespace multitetra
