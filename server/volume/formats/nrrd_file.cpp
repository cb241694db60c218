#include "server/volume/formats/nrrd_file.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/text.hpp"
#include "common/image/nrrd_header.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/nrrd_axes.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"
#include "server/volume/formats/detail/plain_slices.hpp"
#include "server/volume/formats/detail/segment_names.hpp"
#include "server/volume/formats/detail/text_slices.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMaxSkip = std::int64_t{1} << 48;
constexpr const char* kCheckHeader = "Correct the header";

NrrdHeader read_nrrd_header(const fs::path& file) {
  NrrdHeader header = parse_nrrd_header(InputFile(file).beginning(kMaxNrrdHeaderBytes));
  if (!header.text.starts_with("NRRD")) {
    fail_reading(file, "it does not begin with NRRD",
                 "Check that it is a complete file of this format");
  }
  if (!header.has_end && header.bytes == kMaxNrrdHeaderBytes) {
    fail_reading(file, "its header has more than " + std::to_string(kMaxNrrdHeaderBytes) + " bytes",
                 "Check that it is a complete file of this format");
  }
  return header;
}

StoredType nrrd_type(const fs::path& file, const NrrdHeader& header) {
  if (const auto type = stored_type_from_word(header.field("type"))) return *type;
  fail_reading(file, "the type of its samples is '" + header.field("type").substr(0, 40) + "'",
               "Give integers of 8 to 64 bits or floating-point numbers of 32 or 64 bits");
}

std::vector<std::int64_t> sizes_of(const fs::path& file, const NrrdHeader& header) {
  const std::int64_t axes = integer(header.field("dimension")).value_or(0);
  std::vector<std::int64_t> sizes;
  for (const std::string& word : words_of(header.field("sizes"))) {
    sizes.push_back(integer(word).value_or(0));
  }
  const bool is_right = axes >= 1 && sizes.size() == static_cast<std::size_t>(axes) && axes <= 16;
  if (is_right && *std::min_element(sizes.begin(), sizes.end()) >= 1) return sizes;
  fail_reading(file, "the number of its sizes differs from its dimension, or one is below 1",
               kCheckHeader);
}

// ---- location of the samples

// Returns the offset of the samples in a file, after `begin` and the lines to skip.
std::uint64_t behind_lines(const fs::path& file, std::uint64_t begin, std::int64_t lines) {
  constexpr std::size_t kMaxLineBytes = std::size_t{1} << 16;
  std::string text(kMaxLineBytes, '\0');
  text.resize(InputFile(file).read_some(begin, std::as_writable_bytes(std::span(text))));
  std::size_t at = 0;
  for (std::int64_t i = 0; i < lines; ++i) {
    at = text.find('\n', at) + 1;
    if (at == 0) {
      fail_reading(file, "it ends within the lines to skip, or they are too long", kCheckHeader);
    }
  }
  return begin + at;
}

std::vector<fs::path> data_files(const fs::path& file, const NrrdHeader& header,
                                 const std::vector<std::int64_t>& sizes,
                                 bool allow_external_files) {
  const std::string value = header.field("data file");
  if (value.empty()) {
    if (!header.has_end) fail_incomplete(file, "it ends within its header");
    return {file};
  }
  std::vector<std::string> names = {value};
  std::vector<std::string> words = words_of(value);
  const bool is_list = value.starts_with("LIST");
  if (is_list) {
    names = header.listed_files;
    words.insert(words.begin() + 1, 3, "");
  } else if (is_numbered(value)) {
    names = numbered_names(file, value);
  }
  // Each file contains the samples along its first `in_file` axes; the last axis may be divided.
  if (is_list || is_numbered(value)) {
    const auto axes = static_cast<std::int64_t>(sizes.size());
    const std::int64_t in_file = words.size() > 4 ? integer(words[4]).value_or(0) : axes - 1;
    std::int64_t wanted = 1;
    for (std::int64_t axis = std::max<std::int64_t>(in_file, 0); axis < axes; ++axis) {
      wanted *= sizes[static_cast<std::size_t>(axis)];
    }
    const auto count = static_cast<std::int64_t>(names.size());
    const bool is_cut = count > 0 && in_file >= axes - 1 && sizes.back() % count == 0;
    if (in_file < 1 || in_file > axes || (count != wanted && !is_cut)) {
      fail_reading(file,
                   "it lists " + std::to_string(count) + " data files for " +
                       std::to_string(wanted) + " parts of its samples",
                   "Correct the list of files, or the number of axes in each file");
    }
  }
  std::vector<fs::path> files;
  for (const std::string& name : names)
    files.push_back(named_data_file(file, name, allow_external_files));
  return files;
}

Packing packing_of(const fs::path& file, const std::string& encoding) {
  if (encoding == "raw") return Packing::kNone;
  if (encoding == "gzip" || encoding == "gz") return Packing::kGzip;
  if (encoding == "bzip2" || encoding == "bz2") return Packing::kBzip2;
  if (encoding == "hex") return Packing::kHex;
  fail_reading(file, "its encoding is '" + encoding.substr(0, 40) + "'",
               "Save it with encoding raw or gzip");
}

// Returns the size of a file, or of the stream in it after it is unpacked.
std::uint64_t unpacked_size(const fs::path& data, const SamplePart& part) {
  const InputFile file(data);
  if (part.packing == Packing::kNone) return file.size();
  return UnpackedStream(file, part.offset, part.packing).require_good_end();
}

// Returns the slices of `one` after `skipped_volumes` volumes of its size.
std::unique_ptr<StoredSlices> slices_behind(const fs::path& file, const NrrdHeader& header,
                                            const std::vector<fs::path>& files,
                                            std::uint64_t volumes, std::uint64_t skipped_volumes,
                                            const ImageHeader& one) {
  const std::uint64_t volume_bytes = one.volume_bytes();
  const std::uint64_t all_bytes = volumes * volume_bytes;
  const std::string encoding = lower_case(header.field("encoding"));
  const std::int64_t lines = integer(header.field("line skip")).value_or(0);
  const std::int64_t bytes = integer(header.field("byte skip")).value_or(0);
  const bool is_attached = header.field("data file").empty();
  const auto begin = [&](const fs::path& data) {
    return behind_lines(data, is_attached ? header.bytes : 0, lines);
  };
  if (encoding == "text" || encoding == "txt" || encoding == "ascii") {
    if (files.size() != 1) {
      fail_reading(file, "its samples are text in several files, which is not supported",
                   "Save it with encoding raw");
    }
    return text_slices(
        {.file = files[0],
         .begin = begin(files[0]) + static_cast<std::uint64_t>(std::max<std::int64_t>(bytes, 0)),
         .skipped = skipped_volumes * (volume_bytes / bytes_of(one.type)),
         .are_all = skipped_volumes + 1 == volumes},
        one);
  }
  const std::string endian = lower_case(header.field("endian"));
  if (bytes_of(one.type) > 1 && endian != "little" && endian != "big") {
    fail_reading(file, "its header does not state the byte order (endian) of its samples",
                 kCheckHeader);
  }
  SampleParts samples{.part_bytes = all_bytes / files.size(),
                      .first_byte = skipped_volumes * volume_bytes,
                      .endian = endian == "big" ? Endian::kBig : Endian::kLittle,
                      .known_behind = bytes < 0 ? static_cast<std::uint64_t>(-1 - bytes) : 0};
  const Packing packing = packing_of(file, encoding);
  if (lines < 0 || bytes < -kMaxSkip || (bytes < 0 && packing == Packing::kHex)) {
    fail_reading(file, "it skips a negative number of lines or bytes", kCheckHeader);
  }
  for (const fs::path& data : files) {
    SamplePart part{.file = data, .offset = begin(data), .packing = packing};
    std::uint64_t& skipped = packing == Packing::kNone ? part.offset : part.skipped;
    if (bytes >= 0) {
      skipped += static_cast<std::uint64_t>(bytes);
    } else {  // The samples end the file, but for the known bytes behind them.
      const std::uint64_t size = unpacked_size(data, part);
      const std::uint64_t wanted = samples.part_bytes + *samples.known_behind;
      skipped = size < wanted ? 0 : size - wanted;
    }
    samples.parts.push_back(std::move(part));
  }
  return slices_in_parts(std::move(samples), one);
}

}  // namespace

StoredVolume open_nrrd(const fs::path& path, const VolumeChoice& choice) {
  const NrrdHeader header = read_nrrd_header(path);
  const std::vector<std::int64_t> sizes = sizes_of(path, header);
  StoredVolume volume{.header = {.values = kNumbersAsStored}};
  volume.contents.labels = segments_in(header.text);
  // The components of a segmentation are layers, which overlap.
  const bool has_layers = have_layers(volume.contents.labels);
  const bool chooses_component = !choice.time && choice.component != ComponentChoice();
  const NrrdAxes axes = nrrd_axes(path, header, sizes, has_layers || chooses_component);

  ImageHeader one{.type = nrrd_type(path, header), .values = kNumbersAsStored};
  for (std::size_t i = 0; i < axes.space.size(); ++i) one.dims[i] = sizes[axes.space[i]];
  place_nrrd(path, header, axes, sizes, one);
  const std::string old_min = header.field("old min");
  const std::string old_max = header.field("old max");
  if (!old_min.empty() && !old_max.empty()) {
    one.contradictions.push_back(
        {Fact::kScaling, "its numbers stand for " + old_min + " to " + old_max +
                             " (old min, old max); they are read as stored"});
  }
  const std::optional<std::size_t> other = axes.time ? axes.time : axes.component;
  const std::int64_t others = other ? sizes[*other] : 1;
  const std::int64_t time = [&]() -> std::int64_t {
    if (!axes.time) return 0;
    volume.contents.times = nrrd_times(header, *axes.time, others);
    return chosen_time(path, others, choice);
  }();
  volume.header = one;
  if (axes.component || (other == 0U && others > 1)) volume.header.components = others;
  check_header(path, volume.header);
  constexpr std::int64_t kMaxOthers = std::int64_t{1} << 12;
  if (others > kMaxOthers) {
    fail_reading(path, "it has " + std::to_string(others) + " volumes",
                 "Give at most " + std::to_string(kMaxOthers));
  }
  if (has_layers) {
    volume.contents.labels = segments_in(header.text, volume.header.components);
    check_layers(path, volume.contents.labels, volume.header.components, choice);
  }
  const std::vector<fs::path> files = data_files(path, header, sizes, choice.allow_external_files);
  const auto count = static_cast<std::uint64_t>(others);
  if (other == 0U) {
    volume.slices = slices_behind(path, header, files, 1, 0, volume.header);
    if (axes.time && others > 1) volume.component_of_time = static_cast<int>(time);
  } else if (axes.component && others > 1) {
    std::vector<std::unique_ptr<StoredSlices>> components;
    for (std::uint64_t i = 0; i < count; ++i) {
      components.push_back(slices_behind(path, header, files, count, i, one));
    }
    volume.slices = interleaved_slices(std::move(components), volume.header);
  } else {
    volume.slices =
        slices_behind(path, header, files, count, static_cast<std::uint64_t>(time), one);
  }
  return volume;
}

}  // namespace multitetra
