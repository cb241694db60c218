#include "server/volume/formats/hdf5/detail/imaris_volume.hpp"

#include <algorithm>
#include <cstdio>

#include "common/base/parse_number.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMaxImages = 10'000;

// Imaris stores numbers in attributes as text.
std::optional<double> imaris_number(hid_t object, const std::string& name) {
  const std::string text = hdf5_text(object, name.c_str());
  std::string_view rest = text;
  return take_number<double>(rest);
}

std::string dataset_path(std::int64_t level, std::int64_t time, std::int64_t channel) {
  return "/DataSet/ResolutionLevel " + std::to_string(level) + "/TimePoint " +
         std::to_string(time) + "/Channel " + std::to_string(channel) + "/Data";
}

// Returns whether a path leads to an object without links to other files or elsewhere.
bool has_object(hid_t file, const std::string& path) {
  for (std::size_t slash = path.find('/', 1);; slash = path.find('/', slash + 1)) {
    const std::string step = path.substr(0, slash);
    H5L_info_t link;
    if (H5Lexists(file, step.c_str(), H5P_DEFAULT) <= 0 ||
        H5Lget_info(file, step.c_str(), &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
      return false;
    if (slash == std::string::npos) return true;
  }
}

std::int64_t count_of(hid_t file, const std::string& before) {
  std::int64_t count = 0;
  while (count < kMaxImages && has_object(file, before + std::to_string(count))) ++count;
  return count;
}

std::int64_t chosen_of(const fs::path& path, const char* what, std::int64_t count,
                       std::optional<std::int64_t> wanted, bool takes_first) {
  const std::string name = what;
  return chosen_entry(path,
                      {.count = count,
                       .several = "it has " + std::to_string(count) + " " + name + "s",
                       .remedy = "Choose one with --" + name + ", from 0",
                       .missing = "it has no " + name},
                      wanted, takes_first);
}

std::vector<SourceField> imaris_channels(hid_t file, std::int64_t count) {
  std::vector<SourceField> fields;
  for (std::int64_t i = 0; count > 1 && i < count; ++i) {
    const std::string path = "/DataSetInfo/Channel " + std::to_string(i);
    std::string name;
    if (has_object(file, path)) {
      const Hdf5Id group(H5Gopen2(file, path.c_str(), H5P_DEFAULT), &H5Gclose);
      name = member_name_from(hdf5_text(group.get(), "Name"));
    }
    if (name.empty()) name = "channel" + std::to_string(i);
    fields.push_back({.name = std::move(name), .channel = i});
  }
  return fields;
}

}  // namespace

std::optional<ImarisVolume> imaris_volume(const fs::path& path, hid_t file,
                                          const VolumeChoice& choice) {
  if (!has_object(file, dataset_path(0, 0, 0)) || !has_object(file, "/DataSetInfo/Image")) {
    return std::nullopt;
  }
  long long level = choice.level.value_or(0);
  long long time = 0;
  long long channel = 0;
  VolumeContents contents;
  if (choice.array.empty()) {
    const std::int64_t levels = count_of(file, "/DataSet/ResolutionLevel ");
    (void)chosen_of(path, "level", levels, level, true);
    const std::string below = "/DataSet/ResolutionLevel " + std::to_string(level) + "/TimePoint ";
    contents.times.count = count_of(file, below);
    time = chosen_of(path, "time", contents.times.count, choice.time, choice.first);
    const std::int64_t channels = count_of(file, below + std::to_string(time) + "/Channel ");
    channel = chosen_of(path, "channel", channels, choice.channel, choice.first);
    contents.fields = imaris_channels(file, channels);
  } else {
    const std::string name = choice.array.starts_with('/') ? choice.array : "/" + choice.array;
    const char* const form = "/DataSet/ResolutionLevel %lld/TimePoint %lld/Channel %lld/Data";
    if (std::sscanf(name.c_str(), form, &level, &time, &channel) != 3) return std::nullopt;
    if (name != dataset_path(level, time, channel) || !has_object(file, name)) return std::nullopt;
  }
  ImarisVolume volume{.dataset = dataset_path(level, time, channel),
                      .contents = std::move(contents)};
  const std::string channel_path = volume.dataset.substr(0, volume.dataset.rfind('/'));
  const Hdf5Id group(H5Gopen2(file, channel_path.c_str(), H5P_DEFAULT), &H5Gclose);
  const Hdf5Id info(H5Gopen2(file, "/DataSetInfo/Image", H5P_DEFAULT), &H5Gclose);
  const Hdf5Id data(H5Dopen2(group.get(), "Data", H5P_DEFAULT), &H5Dclose);
  const std::vector<hsize_t> stored = hdf5_dims(data.get());
  if (stored.size() != 3) return std::nullopt;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string letter(1, "XYZ"[axis]);
    const auto all = static_cast<double>(stored[2 - axis]);
    const double size = imaris_number(group.get(), "ImageSize" + letter).value_or(all);
    if (!(size >= 1 && size <= all)) {
      fail_damaged(path, "its image is larger than its dataset");
    }
    volume.dims[axis] = static_cast<std::int64_t>(size);
    const std::string number = std::to_string(axis);
    const auto low = imaris_number(info.get(), "ExtMin" + number);
    const auto high = imaris_number(info.get(), "ExtMax" + number);
    if (!low || !high || !(*high > *low)) continue;
    const double spacing = (*high - *low) / static_cast<double>(volume.dims[axis]);
    volume.spacing[axis] = spacing;
    volume.origin[axis] = *low + spacing / 2;
  }
  volume.unit = unit_from(hdf5_text(info.get(), "Unit"));
  return volume;
}

}  // namespace multitetra
