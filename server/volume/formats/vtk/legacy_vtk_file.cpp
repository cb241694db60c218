#include "server/volume/formats/vtk/legacy_vtk_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/text.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"
#include "server/volume/formats/detail/plain_slices.hpp"
#include "server/volume/formats/detail/text_slices.hpp"
#include "server/volume/formats/endian.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxVtkHeaderBytes = std::size_t{1} << 16;

[[noreturn]] void fail_in_header(const fs::path& file, const std::string& problem) {
  fail_reading(file, problem, "Save it as structured points, for example with ParaView");
}

StoredType legacy_vtk_type(const fs::path& file, const std::string& name) {
  std::string word = lower_case(name);
  if (word == "vtkidtype") word = "int";  // VTK writes it as int.
  if (word.starts_with("vtktype")) word.erase(0, 7);
  if (const auto type = stored_type_from_word(word)) return *type;
  fail_in_header(file, "the type of its samples is '" + name.substr(0, 40) + "'");
}

// Reads the lines of the header as words.
class VtkLines {
 public:
  explicit VtkLines(const fs::path& file)
      : file_(file), text_(InputFile(file).beginning(kMaxVtkHeaderBytes)) {}

  // Returns the words of the next line that is not empty.
  std::vector<std::string> next() {
    while (at_ < text_.size()) {
      std::vector<std::string> words = words_of(line());
      if (!words.empty()) return words;
    }
    fail_in_header(file_, "it ends within its header");
  }
  // Returns the next line unchanged.
  std::string line() {
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    std::string line = text_.substr(at_, end - at_);
    at_ = std::min(end + 1, text_.size());
    return line;
  }
  // Returns the next bytes, without the end of line behind them; fewer at the header's end.
  std::string bytes(std::size_t count) {
    std::string bytes = text_.substr(at_, count);
    at_ = std::min(at_ + count + 1, text_.size());
    return bytes;
  }
  // Skips the next line if it begins with this word.
  void skip(std::string_view word) {
    if (lower_case(std::string_view(text_).substr(at_, word.size())) == word) (void)line();
  }
  // Offset after the last line read.
  [[nodiscard]] std::uint64_t position() const { return at_; }

 private:
  const fs::path& file_;
  std::string text_;
  std::size_t at_ = 0;
};

Vec3 three_numbers(const fs::path& file, const std::vector<std::string>& words) {
  Vec3 numbers{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto number = words.size() > i + 1 ? finite_number(words[i + 1]) : std::nullopt;
    if (!number) fail_in_header(file, "its line " + words[0] + " does not have three numbers");
    numbers[i] = *number;
  }
  return numbers;
}

// Returns a big-endian number; none of other types than float and double.
std::optional<double> big_endian_number(StoredType type, std::string bytes) {
  if (bytes.size() != bytes_of(type)) return std::nullopt;
  to_host_order(std::as_writable_bytes(std::span(bytes)), bytes.size(), Endian::kBig);
  double number = 0;
  float single = 0;
  if (type == StoredType::kF64) {
    std::memcpy(&number, bytes.data(), sizeof number);
  } else if (type == StoredType::kF32) {
    std::memcpy(&single, bytes.data(), sizeof single);
    number = single;
  } else {
    return std::nullopt;
  }
  return number;
}

// Reads the first of the arrays of the FIELD in front of the samples, and returns it if it is the
// time: a single finite number named TimeValue (ParaView) or TIME (VisIt). Others are left to the
// caller, which ignores what it does not know.
std::vector<double> time_in(VtkLines& lines, bool is_text) {
  std::vector<std::string> words = lines.next();
  words.resize(4);
  const bool is_time = words[0] == "TimeValue" || words[0] == "TIME";
  const auto type = stored_type_from_word(lower_case(words[3]));
  if (!is_time || words[1] != "1" || words[2] != "1" || !type) return {};
  const std::optional<double> time = is_text
                                         ? finite_number(lines.next()[0])
                                         : big_endian_number(*type, lines.bytes(bytes_of(*type)));
  return time && std::isfinite(*time) ? std::vector{*time} : std::vector<double>();
}

// Reads the format behind the version and the title.
bool is_text_format(const fs::path& path, VtkLines& lines) {
  (void)lines.line();  // The version.
  (void)lines.line();  // A title.
  const std::string format = lower_case(lines.next()[0]);
  if (format == "ascii") return true;
  if (format == "binary") return false;
  fail_in_header(path, "it is neither text nor binary");
}

// Reads from DATASET to the number of samples. Sets the grid; returns the times.
std::vector<double> read_grid(const fs::path& path, VtkLines& lines, bool is_text,
                              ImageHeader& header) {
  const std::vector<std::string> kind = lines.next();
  if (kind.size() < 2 || lower_case(kind[0]) != "dataset" ||
      lower_case(kind[1]) != "structured_points") {
    fail_in_header(path, "it has no DATASET STRUCTURED_POINTS line");
  }
  Vec3 sizes{};
  Vec3 spacing = {1, 1, 1};
  Vec3 origin{};
  std::vector<double> times;
  std::vector<std::string> words;
  for (words = lines.next(); !lower_case(words[0]).ends_with("_data"); words = lines.next()) {
    const std::string word = lower_case(words[0]);
    if (word == "dimensions") sizes = three_numbers(path, words);
    if (word == "spacing" || word == "aspect_ratio") spacing = three_numbers(path, words);
    if (word == "origin") origin = three_numbers(path, words);
    if (word == "field") times = time_in(lines, is_text);
  }
  const bool of_cells = lower_case(words[0]) == "cell_data";
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(sizes[axis] >= 1 && sizes[axis] <= 1e9)) fail_in_header(path, "it has no DIMENSIONS");
    header.dims[axis] = static_cast<std::int64_t>(sizes[axis]);
    if (!of_cells) continue;
    header.dims[axis] = std::max<std::int64_t>(header.dims[axis] - 1, 1);
    origin[axis] += spacing[axis] / 2;
  }
  set_box_axes(header, stated(origin), stated(spacing));
  return times;
}

// Reads the description of the first array, up to its samples.
void read_array(const fs::path& path, VtkLines& lines, ImageHeader& header) {
  std::vector<std::string> words = lines.next();
  const std::string array = lower_case(words[0]);
  words.resize(4);
  if (array == "field") {  // FIELD name count; then: name components tuples type
    words = lines.next();
    words.resize(4);
    header.components = integer(words[1]).value_or(0);
    header.type = legacy_vtk_type(path, words[3]);
    return;
  }
  if (array == "scalars") {
    header.components = words[3].empty() ? 1 : integer(words[3]).value_or(0);
  } else if (array == "vectors" || array == "normals") {
    header.components = 3;
  } else if (array == "tensors") {
    header.components = 9;
  } else {
    fail_in_header(path, "its first array is " + words[0].substr(0, 40));
  }
  header.type = legacy_vtk_type(path, words[2]);
  if (array == "scalars") lines.skip("lookup_table");
}

}  // namespace

StoredVolume open_legacy_vtk(const fs::path& path) {
  VtkLines lines(path);
  const bool is_text = is_text_format(path, lines);
  StoredVolume volume;
  volume.contents.times.at = read_grid(path, lines, is_text, volume.header);
  read_array(path, lines, volume.header);
  check_header(path, volume.header);
  volume.slices = is_text ? text_slices({.file = path, .begin = lines.position()}, volume.header)
                          : plain_slices(path, lines.position(), Endian::kBig, volume.header);
  return volume;
}

}  // namespace multitetra
