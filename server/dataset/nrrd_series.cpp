#include "server/dataset/nrrd_series.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "common/base/text.hpp"
#include "server/dataset/formats/stored_volume.hpp"
#include "server/dataset/nrrd_lines.hpp"
#include "server/dataset/numbered_files.hpp"
#include "server/dataset/payload_size.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kAxes = 4;

// A word for each axis: numbers, names, vectors in brackets, texts in quotes.
std::vector<std::string> axis_words(std::string_view value) {
  std::vector<std::string> words;
  for (value = trimmed(value); !value.empty(); value = trimmed(value)) {
    const char end_mark = value[0] == '(' ? ')' : value[0] == '"' ? '"' : ' ';
    const std::size_t found = value.find(end_mark, 1);
    const std::size_t length = found == std::string_view::npos ? value.size()
                               : end_mark == ' '               ? found
                                                               : found + 1;
    words.emplace_back(value.substr(0, length));
    value.remove_prefix(length);
  }
  return words;
}

// The words of a field that has one for each of four axes; none of another one.
std::vector<std::string> words_of_field(const NrrdLines& lines, std::string_view field) {
  std::vector<std::string> words = axis_words(lines.value(field).value_or(""));
  if (words.size() != kAxes) words.clear();
  return words;
}

std::optional<double> real_number(std::string_view text) {
  double value = 0;
  const auto [at, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || at != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<std::array<std::int64_t, kAxes>> sizes_of(const NrrdLines& lines) {
  const std::vector<std::string> words = words_of_field(lines, "sizes");
  std::array<std::int64_t, kAxes> sizes{};
  if (words.empty() || lines.value("dimension") != "4") return std::nullopt;
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    sizes[axis] = integer(words[axis]).value_or(0);
    if (sizes[axis] < 1 || sizes[axis] > (std::int64_t{1} << 31)) return std::nullopt;
  }
  return sizes;
}

// The axis that is none of space.
std::optional<std::size_t> time_axis(const NrrdLines& lines, bool is_component) {
  const std::vector<std::string> kinds = words_of_field(lines, "kinds");
  std::vector<std::size_t> others;
  for (std::size_t axis = 0; axis < kinds.size(); ++axis) {
    const std::string kind = lower_case(kinds[axis]);
    if (kind == "domain" || kind == "space") continue;
    const bool may_be_time = kind == "time" || kind == "list" || kind == "none" || kind == "???";
    if (!may_be_time || (is_component && kind != "time")) return std::nullopt;
    others.push_back(axis);
  }
  if (others.empty()) {
    const std::vector<std::string> directions = words_of_field(lines, "space directions");
    for (std::size_t axis = 0; axis < directions.size(); ++axis) {
      if (directions[axis] == "none") others.push_back(axis);
    }
  }
  if (others.empty()) others.push_back(kAxes - 1);
  const bool is_outermost = others.front() == 0 || others.front() == kAxes - 1;
  return others.size() == 1 && is_outermost ? std::optional(others.front()) : std::nullopt;
}

// Numbers between spaces or commas.
std::vector<double> numbers_in(std::string text) {
  std::replace(text.begin(), text.end(), ',', ' ');
  std::vector<double> numbers;
  for (const std::string& word : words_of(text)) {
    const std::optional<double> number = real_number(word);
    if (!number || !std::isfinite(*number)) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

SourceTimes times_of(const NrrdLines& lines, std::size_t axis, std::int64_t count) {
  const auto unquoted = [](std::string text) {
    std::erase(text, '"');
    return text;
  };
  const std::string prefix = "axis " + std::to_string(axis) + " index ";
  for (const auto& [values, unit] :
       {std::pair{prefix + "values", prefix + "unit"},
        {"MultiVolume.FrameLabels", "MultiVolume.FrameIdentifyingUnits"}}) {
    SourceTimes times{.count = count, .at = numbers_in(lines.key(values).value_or(""))};
    if (count > 1 && times.at.size() == static_cast<std::size_t>(count)) {
      times.unit = time_unit_from(lines.key(unit).value_or(""));
      return times;
    }
  }
  const auto word = [&](std::string_view field) {
    const std::vector<std::string> words = words_of_field(lines, field);
    return words.empty() ? std::string() : words[axis];
  };
  return even_times(count, real_number(word("axis mins")).value_or(0),
                    real_number(word("spacings")).value_or(0), unquoted(word("units")));
}

std::size_t type_bytes(const std::string& type) {
  const auto has = [&](std::string_view word) { return type.find(word) != std::string::npos; };
  if (has("longlong") || has("long long") || has("int64") || has("double")) return 8;
  if (has("int16") || has("short")) return 2;
  if (has("int8") || has("char")) return 1;
  return has("int") || has("float") ? 4 : 0;
}

// What follows "data file: LIST".
void choose_from_list(const fs::path& file, NrrdLines& lines, std::ptrdiff_t list,
                      std::int64_t count, std::int64_t time) {
  const auto first = lines.lines().begin() + list + 1;
  const std::int64_t files = lines.lines().end() - first;
  if (files == 0 || files % count != 0) {
    fail_reading(file,
                 "it names " + std::to_string(files) + " data files for " + std::to_string(count) +
                     " volumes",
                 "Give files that are each of one volume");
  }
  const std::int64_t each = files / count;
  const std::vector<std::string> chosen(first + time * each, first + (time + 1) * each);
  lines.lines().erase(first - 1, lines.lines().end());
  if (each == 1) return lines.set("data file", chosen.front());
  lines.set("data file", "LIST");
  lines.lines().insert(lines.lines().end(), chosen.begin(), chosen.end());
}

// Skips the volumes before the chosen one; unpacked ones, where they are packed.
void skip_volumes(const fs::path& file, NrrdLines& lines, std::uint64_t volume_bytes,
                  std::int64_t count, std::int64_t time) {
  const std::string name = *lines.value("data file");
  std::int64_t before = integer(lines.value("byte skip").value_or("0")).value_or(0);
  if (before < 0) {  // The samples end the file.
    const std::uint64_t all = volume_bytes * static_cast<std::uint64_t>(count);
    const std::uint64_t found = bytes_after(name, 0);
    require_whole(file, found, all);
    before = static_cast<std::int64_t>(found - all);
    lines.remove("line skip");
  }
  const std::uint64_t skipped = volume_bytes * static_cast<std::uint64_t>(time);
  lines.remove("data file");  // It comes last.
  lines.set("byte skip", std::to_string(static_cast<std::uint64_t>(before) + skipped));
  lines.set("data file", name);
}

}  // namespace

std::optional<NrrdSeries> nrrd_series(std::string_view header, bool is_component) {
  const NrrdLines lines(header);
  const auto sizes = sizes_of(lines);
  if (!sizes) return std::nullopt;
  const std::optional<std::size_t> axis = time_axis(lines, is_component);
  if (!axis) return std::nullopt;
  return NrrdSeries{.times = times_of(lines, *axis, (*sizes)[*axis]), .is_interleaved = *axis == 0};
}

std::string nrrd_header_at(std::string_view header, const fs::path& file, std::int64_t time) {
  NrrdLines lines(header);
  const auto sizes = sizes_of(lines).value();
  const std::string encoding = lower_case(lines.value("encoding").value_or(""));
  if (encoding == "text" || encoding == "txt" || encoding == "ascii" || encoding == "hex") {
    fail_reading(file, "its samples are text and it has several volumes",
                 "Save it with encoding raw or gzip");
  }
  const std::size_t bytes = type_bytes(lower_case(lines.value("type").value_or("")));
  std::uint64_t volume_bytes = bytes;
  for (std::size_t axis = 0; axis + 1 < kAxes; ++axis) {
    if (bytes == 0 || sizes[axis] > kMaxSide) {
      fail_reading(file, "its type or its sizes are not those of a volume",
                   "Each side must have 1 to " + std::to_string(kMaxSide) + " samples");
    }
    volume_bytes *= static_cast<std::uint64_t>(sizes[axis]);
  }
  lines.detach(file);
  lines.set("dimension", "3");
  for (const char* field :
       {"sizes", "spacings", "thicknesses", "axis mins", "axismins", "axis maxs", "axismaxs",
        "centers", "centerings", "kinds", "space directions", "labels"}) {
    const std::vector<std::string> words = words_of_field(lines, field);
    if (words.empty()) continue;
    lines.set(field, words[0] + " " + words[1] + " " + words[2]);
  }
  lines.remove("units");  // Which ITK refuses beside directions.
  if (lines.value("datafile")) {
    lines.lines()[static_cast<std::size_t>(lines.position("datafile"))] =
        "data file: " + *lines.value("datafile");
  }
  const std::string data = lines.value("data file").value_or("");
  if (data.starts_with("LIST")) {
    choose_from_list(file, lines, lines.position("data file"), sizes[3], time);
  } else if (is_numbered(data)) {
    const auto files = numbered_files(data);
    if (!files || files->count != sizes[3] || files->number(time) < 0) {
      fail_reading(file, "its data files are named by '" + data + "'",
                   "Give one file for each volume, or one of all");
    }
    lines.set("data file", files->name(time));
  } else {
    skip_volumes(file, lines, volume_bytes, sizes[3], time);
  }
  return lines.text();
}

}  // namespace multitetra
