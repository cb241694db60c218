#include "server/volume/formats/described_raw.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <regex>
#include <sstream>
#include <utility>
#include <vector>

#include "common/base/number_text.hpp"
#include "common/base/text.hpp"
#include "server/volume/formats/detail/header_bytes.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/plain_slices.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxDescriptionBytes = std::size_t{1} << 16;

// Parses the names of types in files and file names.
std::optional<StoredType> type_word(std::string_view word) {
  const std::string lower = lower_case(word);
  if (lower == "byte") return StoredType::kU8;
  if (lower == "ushort_12") return StoredType::kU16;
  const auto type = stored_type_from_word(lower);
  return type ? type : stored_type_from(lower);
}

// Returns up to three numbers at the beginning of a text.
std::vector<double> leading_numbers(const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  std::vector<double> numbers;
  for (double number = 0; numbers.size() < 3 && in >> number;) numbers.push_back(number);
  return numbers;
}

// The known "name: value" lines of a description.
struct Description {
  std::string data_file;
  std::optional<std::array<std::int64_t, 3>> dims;
  std::optional<StoredType> type;
  StatedNumbers spacing = kNotStated;
  std::optional<Endian> endian;
};

Description description_in(const std::string& text) {
  Description result;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (line.ends_with('\r')) line.pop_back();
    line.resize(std::min(line.find('#'), line.size()));
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) continue;
    const std::string key = lower_case(trimmed(line.substr(0, colon)));
    const std::string value(trimmed(std::string_view(line).substr(colon + 1)));
    const std::vector<double> numbers = leading_numbers(value);
    const bool three = numbers.size() == 3;
    if (key == "objectfilename") result.data_file = value;
    if ((key == "resolution" || key == "dims") && three &&
        std::all_of(numbers.begin(), numbers.end(),
                    [](double x) { return x >= 1 && x <= 1e9 && x == std::floor(x); })) {
      result.dims = {static_cast<std::int64_t>(numbers[0]), static_cast<std::int64_t>(numbers[1]),
                     static_cast<std::int64_t>(numbers[2])};
    }
    if ((key == "slicethickness" || key == "spacing") && three &&
        std::all_of(numbers.begin(), numbers.end(),
                    [](double x) { return x > 0 && std::isfinite(x); })) {
      result.spacing = {numbers[0], numbers[1], numbers[2]};
    }
    if (key == "format" || key == "type") result.type = type_word(value);
    if (key == "byte order" || key == "byteorder" || key == "endian" || key == "endianness") {
      result.endian = lower_case(value).starts_with("big") ? Endian::kBig : Endian::kLittle;
    }
  }
  return result;
}

Description description_of(const fs::path& file) {
  return description_in(InputFile(file).beginning(kMaxDescriptionBytes));
}

DescribedRaw raw_from(const Description& description, fs::path data, const fs::path& described_by) {
  if (!description.dims)
    fail_reading(described_by, "its Resolution is not three positive integers", "Correct it");
  if (!description.type)
    fail_reading(described_by, "its Format is unknown", "Use UCHAR, USHORT or FLOAT");
  DescribedRaw raw{.file = std::move(data),
                   .source = "'" + described_by.filename().string() + "'",
                   .endian = description.endian.value_or(Endian::kLittle)};
  raw.header.dims = *description.dims;
  raw.header.type = *description.type;
  set_box_axes(raw.header, kNotStated, description.spacing);
  check_header(described_by, raw.header);
  return raw;
}

// Adds the spacing from a description beside `file`, for layouts without one.
void add_spacing_beside(const fs::path& file, DescribedRaw& raw) {
  const fs::path beside = fs::path(file).replace_extension(".txt");
  std::error_code error;
  if (beside == file || !fs::is_regular_file(beside, error)) return;
  const Description description = description_of(beside);
  if (description.spacing == kNotStated) return;
  set_box_axes(raw.header, kNotStated, description.spacing);
  raw.source += " and '" + beside.filename().string() + "'";
}

// Returns the unpacked length modulo 2^32 of a gzip stream that ends the file, from its trailer.
std::optional<std::uint32_t> gzip_length(const InputFile& input) {
  if (input.size() < 18) return std::nullopt;
  std::string end(4, '\0');
  input.read(input.size() - end.size(), std::as_writable_bytes(std::span(end)));
  return HeaderBytes(end, Endian::kLittle).at<std::uint32_t>(0);
}

// Finds three counts before the samples. Everything, or only the samples, may be a gzip stream.
std::optional<DescribedRaw> counts_in_front(const fs::path& file) {
  constexpr std::size_t kBytes = 6;
  const InputFile input(file);
  const std::string beginning = unpacked_beginning(input, kBytes);
  if (beginning.size() < kBytes) return std::nullopt;
  const bool all_packed = UnpackedStream::packing_at(input, 0) == Packing::kGzip;
  const bool samples_packed =
      !all_packed && UnpackedStream::packing_at(input, kBytes) == Packing::kGzip;
  const auto packed_length = all_packed || samples_packed ? gzip_length(input) : std::nullopt;
  for (const Endian endian : {Endian::kLittle, Endian::kBig}) {
    const HeaderBytes bytes(beginning, endian);
    DescribedRaw raw{
        .file = file, .source = "its first three numbers", .offset = kBytes, .endian = endian};
    std::uint64_t samples = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      raw.header.dims[axis] = bytes.at<std::uint16_t>(2 * axis);
      samples *= static_cast<std::uint64_t>(raw.header.dims[axis]);
    }
    raw.header.type = StoredType::kU16;
    const bool fits_plain = input.size() == kBytes + 2 * samples;
    const std::uint64_t unpacked = 2 * samples + (all_packed ? kBytes : 0);
    const bool fits_packed =
        packed_length && *packed_length == static_cast<std::uint32_t>(unpacked);
    if (samples == 0 || !(fits_plain || fits_packed)) continue;
    raw.begins_packed = samples_packed && fits_packed;
    check_header(file, raw.header);
    return raw;
  }
  return std::nullopt;
}

// Parses names such as fuel_64x64x64_uint8.raw.
std::optional<DescribedRaw> layout_from_name(const fs::path& file) {
  static const std::regex kLayout(
      R"(_(\d{1,6})x(\d{1,6})x(\d{1,6})_([a-z0-9]+)\.raw(\.gz|\.bz2)?$)");
  const std::string file_name = file.filename().string();
  std::smatch match;
  if (!std::regex_search(file_name, match, kLayout)) return std::nullopt;
  const auto type = type_word(match[4].str());
  if (!type) return std::nullopt;
  DescribedRaw raw{.file = file, .source = "its name"};
  for (std::size_t axis = 0; axis < 3; ++axis)
    raw.header.dims[axis] = std::stoll(match[axis + 1].str());
  raw.header.type = *type;
  check_header(file, raw.header);
  return raw;
}

}  // namespace

StoredVolume open_raw(const fs::path& file, const RawLayout& layout) {
  ImageHeader header{.type = layout.type, .values = kNumbersAsStored};
  for (std::size_t axis = 0; axis < 3; ++axis) header.dims[axis] = layout.dims[axis];
  check_header(file, header);
  const std::uint64_t found = InputFile(file).size();
  const std::uint64_t needed = header.volume_bytes();
  const Packing packing = UnpackedStream::packing_at(InputFile(file), 0);
  if (found == layout.header_bytes + needed) {
    return {.header = header,
            .slices = plain_slices(file, layout.header_bytes, layout.endian, header)};
  }
  if (packing == Packing::kGzip || packing == Packing::kBzip2) {
    return {.header = header,
            .slices = slices_in_file(file, layout.header_bytes, layout.endian, header, 0)};
  }
  fail_reading(file,
               "it has " + std::to_string(found) + " bytes, but the given layout requires " +
                   std::to_string(layout.header_bytes) + " for the header and " +
                   std::to_string(needed) + " for the samples (" + sides_text(layout.dims) +
                   " of type " + std::string(name(layout.type)) + ")",
               "Correct the dims, the type or the header bytes");
}

bool is_raw_description(std::string_view beginning) {
  // Accepts text with lines in any order, also after comments.
  const bool is_text = std::all_of(beginning.begin(), beginning.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\r' || c == '\t';
  });
  if (!is_text) return false;
  const std::string lower = lower_case(beginning);
  return (lower.starts_with("objectfilename") ||
          lower.find("\nobjectfilename") != std::string::npos) &&
         lower.find("resolution") != std::string::npos;
}

DescribedRaw described_raw(const fs::path& file, bool allow_external_files) {
  const Description description = description_of(file);
  if (description.data_file.empty()) {
    fail_reading(file, "its ObjectFileName is empty", "Correct it");
  }
  return raw_from(description, named_data_file(file, description.data_file, allow_external_files),
                  file);
}

std::optional<DescribedRaw> layout_of_raw(const fs::path& file) {
  std::optional<DescribedRaw> raw;
  const fs::path beside = fs::path(file).replace_extension(".dat");
  std::error_code error;
  if (beside != file && fs::is_regular_file(beside, error)) {
    const Description description = description_of(beside);
    if (description.data_file == file.filename()) raw = raw_from(description, file, beside);
  }
  if (!raw) raw = counts_in_front(file);
  if (!raw) raw = layout_from_name(file);
  if (!raw) return std::nullopt;
  const fs::path stem = file.extension() == ".gz" || file.extension() == ".bz2"
                            ? fs::path(file).replace_extension()
                            : file;
  add_spacing_beside(stem, *raw);
  const InputFile input(file);
  const bool packed = UnpackedStream::packing_at(input, 0) == Packing::kGzip;
  if (!packed && !raw->begins_packed && !file.extension().string().ends_with("z2") &&
      input.size() != raw->offset + raw->header.volume_bytes()) {
    fail_reading(file,
                 "it has " + std::to_string(input.size()) + " bytes, but " + raw->source +
                     " states " + std::to_string(raw->offset + raw->header.volume_bytes()),
                 "Give the layout with --dims and --type");
  }
  return raw;
}

StoredVolume open_described(const DescribedRaw& raw) {
  if (raw.begins_packed) {
    return {.header = raw.header,
            .slices = slices_in_parts(
                {.parts = {{.file = raw.file, .offset = raw.offset, .packing = Packing::kGzip}},
                 .part_bytes = raw.header.volume_bytes(),
                 .endian = raw.endian,
                 .known_behind = 0},
                raw.header)};
  }
  return {.header = raw.header,
          .slices = slices_in_file(raw.file, raw.offset, raw.endian, raw.header, 0)};
}

}  // namespace multitetra
