#include "server/volume/formats/vtk/detail/legacy_vtk_header.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "common/base/hex_text.hpp"
#include "common/base/text.hpp"
#include "server/volume/formats/detail/numbered_files.hpp"
#include "server/volume/formats/endian.hpp"

namespace multitetra {
namespace {

constexpr std::string_view kWhiteSpace = " \t\r\n\v\f";
constexpr std::size_t kMaxLegacyArrays = 4096;
constexpr std::int64_t kMaxTuples = std::int64_t{1} << 48;

[[noreturn]] void fail_in_header(const InputFile& file, const std::string& problem) {
  fail_reading(file.path(), problem, "Save it as structured points, for example with ParaView");
}

// A position in a file of lines and samples.
class LegacyCursor {
 public:
  explicit LegacyCursor(const InputFile& file) : file_(file) {}

  [[nodiscard]] std::uint64_t at() const { return at_; }

  // Returns the next line, at most kPortionBytes of it; nullopt at the end of the file.
  std::optional<std::string> line() {
    const std::string_view text = portion();
    if (text.empty()) return std::nullopt;
    const std::size_t end = text.find('\n');
    std::string line(text.substr(0, end));
    at_ += end == std::string_view::npos ? text.size() : end + 1;
    return line;
  }

  // Returns the words of the next line that is not empty; none at the end of the file.
  std::vector<std::string> words() {
    while (const std::optional<std::string> next = line()) {
      std::vector<std::string> words = words_of(*next);
      if (!words.empty()) return words;
    }
    return {};
  }

  [[nodiscard]] bool begins_with(std::string_view word) {
    return lower_case(portion().substr(0, word.size())) == word;
  }

  std::string bytes(std::size_t count) {
    std::string bytes(portion().substr(0, count));
    at_ += count;
    return bytes;
  }
  void skip_bytes(std::uint64_t count) { at_ += count; }

  void skip_words(std::uint64_t count) {
    while (true) {
      const std::string_view text = portion();
      std::size_t used = std::min(text.find_first_not_of(kWhiteSpace), text.size());
      while (count > 0 && used < text.size()) {
        const std::size_t end = text.find_first_of(kWhiteSpace, used);
        if (end == std::string_view::npos && text.size() == kPortionBytes) break;
        --count;
        used = std::min(text.find_first_not_of(kWhiteSpace, end), text.size());
      }
      at_ += used;
      if (count == 0 || used == 0) return;
    }
  }

 private:
  static constexpr std::size_t kPortionBytes = std::size_t{1} << 16;

  // Returns the bytes from here, up to kPortionBytes.
  std::string_view portion() {
    if (at_ < begin_ || at_ + kPortionBytes > begin_ + text_.size()) {
      text_.resize(4 * kPortionBytes);
      begin_ = at_;
      text_.resize(file_.read_some(begin_, std::as_writable_bytes(std::span(text_))));
    }
    return std::string_view(text_).substr(at_ - begin_, kPortionBytes);
  }

  const InputFile& file_;
  std::string text_;
  std::uint64_t begin_ = 0;  // Offset of text_ in the file.
  std::uint64_t at_ = 0;
};

std::optional<StoredType> legacy_type(const std::string& name) {
  std::string word = lower_case(name);
  if (word == "vtkidtype") word = "int";  // VTK writes it as int.
  if (word.starts_with("vtktype")) word.erase(0, 7);
  return stored_type_from_word(word);
}

// Names are encoded as in addresses: "%20" is a space.
std::string decoded_name(const std::string& name) {
  std::string decoded;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto digit = [&](std::size_t at) {
      return at < name.size() ? value_of_hex_digit(name[at]) : std::nullopt;
    };
    const auto high = digit(i + 1);
    const auto low = digit(i + 2);
    if (name[i] == '%' && high && low) {
      decoded += static_cast<char>(*high << 4 | *low);
      i += 2;
    } else {
      decoded += name[i];
    }
  }
  return decoded;
}

class LegacyParser {
 public:
  explicit LegacyParser(const InputFile& file) : file_(file), in_(file) {}

  LegacyVtkHeader parse() {
    read_format();
    std::vector<std::string> section = read_grid();
    while (!section.empty() && header_.arrays.size() < kMaxLegacyArrays)
      section = read_section(section);
    if (!section.empty()) header_.unread = section[0].substr(0, 40);
    if (header_.arrays.empty()) {
      fail_in_header(file_, section.empty() ? "it ends within its header"
                                            : "its first array is " + header_.unread);
    }
    return header_;
  }

 private:
  std::vector<std::string> needed_words() {
    std::vector<std::string> words = in_.words();
    if (words.empty()) fail_in_header(file_, "it ends within its header");
    return words;
  }

  void read_format() {
    (void)in_.line();  // The version.
    (void)in_.line();  // A title.
    const std::string format = lower_case(needed_words()[0]);
    if (format != "ascii" && format != "binary") {
      fail_in_header(file_, "it is neither text nor binary");
    }
    header_.is_text = format == "ascii";
  }

  [[nodiscard]] Vec3 three_numbers(const std::vector<std::string>& words) const {
    Vec3 numbers{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto number = words.size() > i + 1 ? finite_number(words[i + 1]) : std::nullopt;
      if (!number) fail_in_header(file_, "its line " + words[0] + " does not have three numbers");
      numbers[i] = *number;
    }
    return numbers;
  }

  // Returns the line that begins the samples: POINT_DATA or CELL_DATA, and their number.
  std::vector<std::string> read_grid() {
    std::vector<std::string> words = needed_words();
    if (words.size() < 2 || lower_case(words[0]) != "dataset" ||
        lower_case(words[1]) != "structured_points") {
      fail_in_header(file_, "it has no DATASET STRUCTURED_POINTS line");
    }
    Vec3 sizes{};
    for (words = needed_words(); !lower_case(words[0]).ends_with("_data"); words = needed_words()) {
      const std::string word = lower_case(words[0]);
      if (word == "dimensions") sizes = three_numbers(words);
      if (word == "spacing" || word == "aspect_ratio") header_.spacing = three_numbers(words);
      if (word == "origin") header_.origin = three_numbers(words);
      if (word == "field") read_time();
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!(sizes[axis] >= 1 && sizes[axis] <= kMaxSide)) {
        fail_in_header(
            file_, "its DIMENSIONS are not three numbers from 1 to " + std::to_string(kMaxSide));
      }
      header_.points[axis] = static_cast<std::int64_t>(sizes[axis]);
    }
    return words;
  }

  // Reads the first array of a FIELD in front of the samples, which is the time if it is a single
  // finite number named TimeValue (ParaView) or TIME (VisIt). Lines of others are skipped.
  void read_time() {
    std::vector<std::string> words = needed_words();
    words.resize(4);
    const auto type = legacy_type(words[3]);
    if ((words[0] != "TimeValue" && words[0] != "TIME") || words[1] != "1" || words[2] != "1" ||
        (type != StoredType::kF32 && type != StoredType::kF64)) {
      return;
    }
    double time = std::nan("");
    if (header_.is_text) {
      time = finite_number(needed_words()[0]).value_or(time);
    } else {
      std::string bytes = in_.bytes(bytes_of(*type));
      to_host_order(std::as_writable_bytes(std::span(bytes)), bytes.size(), Endian::kBig);
      float single = 0;
      if (bytes.size() == sizeof time) std::memcpy(&time, bytes.data(), sizeof time);
      if (bytes.size() == sizeof single) {
        std::memcpy(&single, bytes.data(), sizeof single);
        time = single;
      }
    }
    if (std::isfinite(time)) header_.times = {time};
  }

  // Reads the arrays behind POINT_DATA or CELL_DATA. Returns the line that begins another section
  // or an unknown part; nothing at the end of the file.
  std::vector<std::string> read_section(const std::vector<std::string>& section) {
    const std::string kind = lower_case(section[0]);
    of_cells_ = kind == "cell_data";
    if (!of_cells_ && kind != "point_data") {
      header_.unread = section[0].substr(0, 40);
      return {};
    }
    const std::array<std::int64_t, 3> dims = of_cells_ ? header_.cells() : header_.points;
    tuples_ = dims[0] * dims[1] * dims[2];
    if (section.size() < 2 || integer(section[1]) != tuples_) {
      fail_in_header(file_, "its line " + section[0] + " does not state " +
                                std::to_string(tuples_) + " samples, as its DIMENSIONS do");
    }
    while (header_.arrays.size() < kMaxLegacyArrays) {
      const std::vector<std::string> words = in_.words();
      if (words.empty() || lower_case(words[0]).ends_with("_data")) return words;
      if (read_attribute(words)) continue;
      if (header_.arrays.empty())
        fail_in_header(file_, "its first array is " + words[0].substr(0, 40));
      header_.unread = words[0].substr(0, 40);
      return {};
    }
    return {};
  }

  // Reads an attribute with its samples; returns false if it is unknown.
  bool read_attribute(std::vector<std::string> words) {
    static const std::map<std::string, std::int64_t, std::less<>> kComponents = {
        {"vectors", 3},    {"normals", 3},      {"tensors", 9},   {"tensors6", 6},
        {"global_ids", 1}, {"pedigree_ids", 1}, {"edge_flags", 1}};
    const std::string kind = lower_case(words[0]);
    words.resize(4);
    if (kind == "metadata") {  // Ends with an empty line.
      std::optional<std::string> line = in_.line();
      while (line && !trimmed(*line).empty()) line = in_.line();
      return true;
    }
    if (kind == "field") {
      for (std::int64_t i = integer(words[2]).value_or(0); i > 0; --i) {
        std::vector<std::string> array = in_.words();
        if (!array.empty() && lower_case(array[0]) == "metadata") {
          (void)read_attribute(array);
          array = in_.words();
        }
        array.resize(4);
        if (!add_array(array[0], array[3], integer(array[1]), integer(array[2]))) return false;
      }
      return true;
    }
    if (kind == "lookup_table") {  // Colors: not samples.
      skip_samples(StoredType::kU8, 4 * std::min(integer(words[2]).value_or(0), kMaxTuples));
      return true;
    }
    if (kind == "color_scalars") {
      const std::size_t before = header_.arrays.size();
      const std::string type = header_.is_text ? "float" : "unsigned_char";
      if (!add_array(words[1], type, integer(words[2]), tuples_)) return false;
      if (header_.is_text && header_.arrays.size() > before) header_.arrays.back().slope = 255;
      return true;
    }
    if (kind == "texture_coordinates") {
      return add_array(words[1], words[3], integer(words[2]), tuples_);
    }
    if (kind == "scalars") {
      if (in_.begins_with("lookup_table")) (void)in_.line();
      return add_array(words[1], words[2], words[3].empty() ? 1 : integer(words[3]), tuples_);
    }
    const auto found = kComponents.find(kind);
    return found != kComponents.end() && add_array(words[1], words[2], found->second, tuples_);
  }

  // Adds an array whose samples are next, if it has as many as the grid, and skips them.
  bool add_array(const std::string& name, const std::string& type_name,
                 std::optional<std::int64_t> components, std::optional<std::int64_t> tuples) {
    if (!components || *components < 1 || *components > kMaxComponents || !tuples || *tuples < 0 ||
        *tuples > kMaxTuples) {
      fail_in_header(file_, "its array '" + name.substr(0, 100) + "' has an invalid size");
    }
    const std::optional<StoredType> type = legacy_type(type_name);
    if (!type) {
      if (skip_others(type_name, *components * *tuples)) return true;
      if (!header_.arrays.empty()) return false;
      fail_in_header(file_, "the type of its samples is '" + type_name.substr(0, 40) + "'");
    }
    if (*tuples == tuples_) {
      header_.arrays.push_back(
          {.name = decoded_name(name),
           .type = *type,
           .components = *components,
           .format = header_.is_text ? VtiArray::Format::kText : VtiArray::Format::kAppended,
           .of_cells = of_cells_,
           .section = of_cells_ ? "CellData" : "PointData",
           .begin = in_.at()});
    }
    skip_samples(*type, *components * *tuples);
    return true;
  }

  // Skips an array of bits or of strings, which are no samples; returns false if it is neither.
  bool skip_others(const std::string& type, std::int64_t count) {
    if (type == "bit") {
      skip_samples(StoredType::kU8, header_.is_text ? count : (count + 7) / 8);
      return true;
    }
    if (type != "string") return false;
    for (bool is_there = true; count > 0 && is_there; --count) {
      is_there = header_.is_text ? in_.line().has_value() : skip_string();
    }
    return true;
  }

  // Skips a string behind its length, whose first two bits tell how many bytes it has: 8, 4, 2, 1.
  bool skip_string() {
    const std::string first = in_.bytes(1);
    if (first.empty()) return false;
    const auto byte = static_cast<unsigned char>(first[0]);
    std::uint64_t length = byte & 0x3F;
    for (const char c : in_.bytes((std::size_t{8} >> (byte >> 6)) - 1)) {
      length = length << 8 | static_cast<unsigned char>(c);
    }
    in_.skip_bytes(std::min(length, static_cast<std::uint64_t>(kMaxTuples)));
    return true;
  }

  void skip_samples(StoredType type, std::int64_t count) {
    const auto numbers = static_cast<std::uint64_t>(std::max<std::int64_t>(count, 0));
    if (header_.is_text) return in_.skip_words(numbers);
    in_.skip_bytes(numbers * bytes_of(type));
    if (in_.begins_with("\n")) in_.skip_bytes(1);
  }

  const InputFile& file_;
  LegacyCursor in_;
  LegacyVtkHeader header_;
  bool of_cells_ = false;    // Of the section that is read.
  std::int64_t tuples_ = 0;  // Samples of its grid.
};

}  // namespace

std::array<std::int64_t, 3> LegacyVtkHeader::cells() const {
  std::array<std::int64_t, 3> cells = points;
  for (std::int64_t& side : cells) side = std::max<std::int64_t>(side - 1, 1);
  return cells;
}

LegacyVtkHeader parse_legacy_vtk(const InputFile& file) { return LegacyParser(file).parse(); }

}  // namespace multitetra
