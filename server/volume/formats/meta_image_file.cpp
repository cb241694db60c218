#include "server/volume/formats/meta_image_file.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/text.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"
#include "server/volume/formats/detail/plain_slices.hpp"
#include "server/volume/formats/detail/text_slices.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxMetaHeaderBytes = std::size_t{1} << 16;

struct MetaHeader {
  std::map<std::string, std::string, std::less<>> values;  // "Name = value"
  std::vector<std::string> listed_files;                   // Lines after "ElementDataFile = LIST".
  std::size_t bytes = 0;                                   // Offset of samples in the same file.

  // Returns the value of the first of these names that is present, or nothing.
  [[nodiscard]] std::string value(std::initializer_list<std::string_view> names) const {
    for (const std::string_view name : names) {
      if (const auto found = values.find(name); found != values.end()) return found->second;
    }
    return {};
  }
  [[nodiscard]] bool is_true(std::initializer_list<std::string_view> names, bool otherwise) const {
    const std::string text = value(names);
    return text.empty() ? otherwise : text[0] == 'T' || text[0] == 't' || text[0] == '1';
  }
};

MetaHeader read_meta_header(const fs::path& file) {
  MetaHeader header;
  const std::string text = InputFile(file).beginning(kMaxMetaHeaderBytes);
  for (std::string_view rest = text; !rest.empty();) {
    const std::string_view line = take_line(rest);
    const std::string data_file = header.value({"ElementDataFile"});
    if (data_file.starts_with("LIST")) {
      if (!trimmed(line).empty()) header.listed_files.emplace_back(trimmed(line));
      continue;
    }
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    const std::string name(trimmed(line.substr(0, equals)));
    header.values[name] = trimmed(line.substr(equals + 1));
    if (name != "ElementDataFile") continue;
    header.bytes = text.size() - rest.size();
    if (!header.values[name].starts_with("LIST")) return header;
  }
  if (!header.value({"ElementDataFile"}).empty()) return header;
  fail_reading(file,
               "there is no ElementDataFile line in its first " +
                   std::to_string(kMaxMetaHeaderBytes) + " bytes",
               "Check that it is a complete file of this format");
}

// MetaImage's long has 32 bits.
StoredType meta_type(const fs::path& file, const std::string& name) {
  const auto type = stored_type_from_word(name);
  if (name == "MET_LONG") return StoredType::kI32;
  if (name == "MET_ULONG") return StoredType::kU32;
  if (type) return *type;
  fail_reading(file, "its ElementType is '" + name.substr(0, 40) + "'",
               "Give integers of 8 to 64 bits or floating-point numbers of 32 or 64 bits");
}

// Returns the `count` numbers of the first name that is present; nullopt if none is.
std::optional<std::vector<double>> numbers_of(const fs::path& file, const MetaHeader& header,
                                              std::initializer_list<std::string_view> names,
                                              std::size_t count) {
  const std::string text = header.value(names);
  if (text.empty()) return std::nullopt;
  std::vector<double> numbers = finite_numbers(text);
  if (numbers.size() >= count) return numbers;
  fail_reading(
      file,
      "its " + std::string(*names.begin()) + " does not have " + std::to_string(count) + " numbers",
      "Correct the header");
}

void place_meta_image(const fs::path& file, const MetaHeader& header, std::size_t axes,
                      const std::optional<std::vector<double>>& spacing,
                      const std::optional<std::vector<double>>& origin, ImageHeader& image) {
  const auto matrix =
      numbers_of(file, header, {"TransformMatrix", "Rotation", "Orientation"}, axes * axes);
  std::array<Vec3, 3> steps = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  StatedNumbers first = kNotStated;
  const std::size_t of_space = std::min<std::size_t>(axes, 3);
  for (std::size_t axis = 0; axis < of_space; ++axis) {
    if (origin) first[axis] = (*origin)[axis];
    for (std::size_t row = 0; row < of_space; ++row) {
      steps[axis][row] = (matrix        ? (*matrix)[axis * axes + row]
                          : axis == row ? 1
                                        : 0) *
                         (spacing ? (*spacing)[axis] : 1);
    }
  }
  set_axes(image, steps, first);
  if (!spacing) image.geometry.spacing = kNotStated;
  const std::string orientation = header.value({"AnatomicalOrientation"}).substr(0, 3);
  if (orientation.size() == 3 && orientation.find_first_not_of("RLAPIS") == std::string::npos) {
    image.meaning = {.space = WorldSpace::kLps, .length_unit = "mm", .value_unit = {}};
  }
  const std::string unit = header.value({"DistanceUnits"});
  if (!unit.empty() && unit != "?") image.meaning.length_unit = unit_from(unit);
  const std::string slope = header.value({"ElementToIntensityFunctionSlope"});
  const std::string offset = header.value({"ElementToIntensityFunctionOffset"});
  if (finite_number(slope).value_or(1) != 1 || finite_number(offset).value_or(0) != 0) {
    image.contradictions.push_back({Fact::kScaling,
                                    "its ElementToIntensityFunction is not applied, as in ITK; its "
                                    "numbers are read as stored"});
  }
}

std::vector<fs::path> meta_data_files(const fs::path& file, const MetaHeader& header,
                                      bool allow_external_files) {
  const std::string value = header.value({"ElementDataFile"});
  if (lower_case(value) == "local") return {file};
  std::vector<std::string> names = {value};
  if (value.starts_with("LIST")) {
    names = header.listed_files;
  } else if (is_numbered(value)) {
    names = numbered_names(file, value);
  }
  std::vector<fs::path> paths;
  for (const std::string& name : names)
    paths.push_back(named_data_file(file, name, allow_external_files));
  return paths;
}

// Returns the slices of volume `time`, of `times` consecutive ones.
std::unique_ptr<StoredSlices> meta_slices(const fs::path& file, const MetaHeader& header,
                                          bool allow_external_files, std::int64_t times,
                                          std::int64_t time, const ImageHeader& image) {
  const std::vector<fs::path> files = meta_data_files(file, header, allow_external_files);
  const std::uint64_t volume_bytes = image.volume_bytes();
  const std::uint64_t all_bytes = volume_bytes * static_cast<std::uint64_t>(times);
  const std::uint64_t skipped = volume_bytes * static_cast<std::uint64_t>(time);
  if (files.empty() || all_bytes % files.size() != 0) {
    fail_reading(file,
                 "its samples cannot be divided evenly among its " + std::to_string(files.size()) +
                     " data files",
                 "Correct the header");
  }
  const std::int64_t header_size = integer(header.value({"HeaderSize"})).value_or(0);
  const bool is_local = files[0] == file;
  const auto offset = [&](const fs::path& data, std::uint64_t part_bytes) -> std::uint64_t {
    if (header_size > 0) return static_cast<std::uint64_t>(header_size);
    if (header_size == 0) return is_local ? header.bytes : 0;
    const std::uint64_t size = InputFile(data).size();  // The samples end the file.
    return size < part_bytes ? 0 : size - part_bytes;
  };
  const bool is_packed = header.is_true({"CompressedData"}, false);
  if (!header.is_true({"BinaryData"}, true)) {
    if (files.size() > 1) {
      fail_reading(file, "its samples are text in several files, which is not supported",
                   "Save it as binary");
    }
    return text_slices({.file = files[0],
                        .begin = header_size > 0 || is_local ? offset(files[0], 0) : 0,
                        .skipped = skipped / bytes_of(image.type),
                        .are_all = time + 1 == times},
                       image);
  }
  const bool is_big = header.is_true({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"}, false);
  SampleParts samples{.part_bytes = all_bytes / files.size(),
                      .first_byte = skipped,
                      .endian = is_big ? Endian::kBig : Endian::kLittle,
                      .known_behind = 0};
  for (const fs::path& data : files) {
    samples.parts.push_back({.file = data,
                             .offset = is_packed && header_size < 0
                                           ? (is_local ? header.bytes : 0)
                                           : offset(data, samples.part_bytes),
                             .packing = is_packed ? Packing::kZlib : Packing::kNone});
  }
  return slices_in_parts(std::move(samples), image);
}

}  // namespace

StoredVolume open_meta_image(const fs::path& path, const VolumeChoice& choice) {
  const MetaHeader header = read_meta_header(path);
  const std::string dimensions = header.value({"NDims"});
  const std::int64_t axes = integer(dimensions).value_or(0);
  if (axes < 2 || axes > 4) {
    fail_reading(path, "its NDims is '" + dimensions.substr(0, 40) + "'",
                 "Give an image or a volume: 2 or 3, or 4 for several times");
  }
  const auto count = static_cast<std::size_t>(axes);
  const auto sizes = numbers_of(path, header, {"DimSize"}, count);
  const auto spacing = numbers_of(path, header, {"ElementSpacing", "ElementSize"}, count);
  const auto origin = numbers_of(path, header, {"Offset", "Position", "Origin"}, count);
  if (!sizes) fail_reading(path, "it has no DimSize", "Correct the header");

  StoredVolume volume{.header = {.type = meta_type(path, header.value({"ElementType"})),
                                 .values = kNumbersAsStored}};
  volume.header.components = integer(header.value({"ElementNumberOfChannels"})).value_or(1);
  std::array<std::int64_t, 4> dims = {1, 1, 1, 1};
  for (std::size_t axis = 0; axis < count; ++axis) {
    const double size = (*sizes)[axis];
    if (!(size >= 1 && size <= 1e9)) {
      fail_reading(path, "its DimSize is '" + header.value({"DimSize"}).substr(0, 60) + "'",
                   "Correct the header");
    }
    dims[axis] = static_cast<std::int64_t>(size);
  }
  volume.header.dims = {dims[0], dims[1], dims[2]};
  place_meta_image(path, header, count, spacing, origin, volume.header);
  check_header(path, volume.header);
  if (dims[3] > std::int64_t{kMaxSourceMembers}) {
    fail_reading(path, "it has " + std::to_string(dims[3]) + " volumes", "Give fewer at a time");
  }
  volume.contents.times.count = dims[3];
  if (axes == 4 && spacing) {
    volume.contents.times =
        even_times(dims[3], origin ? (*origin)[3] : 0, (*spacing)[3], /*unit=*/"");
  }
  volume.slices = meta_slices(path, header, choice.allow_external_files, dims[3],
                              chosen_time(path, dims[3], choice), volume.header);
  return volume;
}

}  // namespace multitetra
