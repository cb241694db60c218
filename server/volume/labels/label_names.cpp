#include "server/volume/labels/label_names.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/base/open_file.hpp"
#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"
#include "common/base/utf8.hpp"
#include "common/sandbox/packed.hpp"
#include "common/sandbox/sandbox.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

namespace {

constexpr std::size_t kMaxNameFileBytes = std::size_t{4} << 20;

// A word of a line. A word in double quotes may contain spaces or be empty.
struct Word {
  std::string_view text;
  bool is_quoted = false;
};

// Returns nullopt if a quote does not end.
std::optional<std::vector<Word>> words_in(std::string_view line) {
  std::vector<Word> words;
  for (line = trimmed(line); !line.empty(); line = trimmed(line)) {
    const bool is_quoted = line[0] == '"';
    const std::size_t end = is_quoted ? line.find('"', 1) : line.find_first_of(" \t");
    if (is_quoted && end == std::string_view::npos) return std::nullopt;
    const std::size_t length = end == std::string_view::npos ? line.size() : end;
    words.push_back({.text = is_quoted ? line.substr(1, length - 1) : line.substr(0, length),
                     .is_quoted = is_quoted});
    line.remove_prefix(is_quoted ? length + 1 : length);
  }
  return words;
}

std::optional<std::int64_t> whole_number(const Word& word) {
  return word.is_quoted ? std::nullopt : parse_number<std::int64_t>(word.text);
}

// Returns the color in words[first] to words[first + 2].
std::optional<std::uint32_t> color_at(const std::vector<Word>& words, std::size_t first) {
  std::uint32_t color = 0;
  for (std::size_t i = first; i < first + 3; ++i) {
    const auto part = i < words.size() ? whole_number(words[i]) : std::nullopt;
    if (!part || *part < 0 || *part > 255) return std::nullopt;
    color = color << 8 | static_cast<std::uint32_t>(*part);
  }
  return color;
}

// Parses 3 221 130 101 1 1 1 "liver"
std::optional<Label> snap_label(const std::vector<Word>& words) {
  if (words.size() != 8 || !words[7].is_quoted) return std::nullopt;
  const auto color = color_at(words, 1);
  if (!color) return std::nullopt;
  return Label{.value = 0, .name = std::string(words[7].text), .color = color};
}

// Parses 3 liver 221 130 101 255
std::optional<Label> table_label(const std::vector<Word>& words) {
  if (words.size() != 5 && words.size() != 6) return std::nullopt;
  const auto color = color_at(words, 2);
  if (!color || (words.size() == 6 && !whole_number(words[5]))) return std::nullopt;
  return Label{.value = 0, .name = std::string(words[1].text), .color = color};
}

std::optional<Label> label_of(std::string_view line) {
  const auto words = words_in(line);
  if (!words || words->empty()) return std::nullopt;
  const std::optional<std::int64_t> value = whole_number(words->front());
  std::optional<Label> label = snap_label(*words);
  if (!label) label = table_label(*words);
  if (!value || !label) return std::nullopt;
  label->value = static_cast<double>(*value);
  return check_member({.series = "labels", .label = *label}) ? label : std::nullopt;
}

}  // namespace

Result<std::vector<Label>> parse_label_names(std::string_view text) {
  std::vector<Label> labels;
  std::set<double> seen;
  const auto wrong = [](std::size_t number, const std::string& what) {
    return fail(ErrorCode::kInvalidArgument, "line " + std::to_string(number) + " " + what);
  };
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = trimmed(take_line(text));
    if (line.empty() || line.starts_with('#')) continue;
    std::optional<Label> label = label_of(line);
    if (!label) {
      return wrong(
          number,
          "is not a label such as '3 liver 221 130 101 255' or '3 221 130 101 1 1 1 \"liver\"' "
          "(number, name of at most 255 bytes, red, green and blue from 0 to 255)");
    }
    if (!seen.insert(label->value).second) {
      return wrong(number, "lists label " +
                               std::to_string(static_cast<std::int64_t>(label->value)) +
                               " a second time");
    }
    labels.push_back(*std::move(label));
  }
  return labels;
}

namespace {

std::vector<Label> read_here(const std::filesystem::path& file) {
  const OpenFile opened(file);
  if (!opened.regular_size())
    fail_reading(file, "it is no file, or cannot be opened", "Check the name");
  const auto text = opened.content(kMaxNameFileBytes + 1);
  if (!text) fail_reading(file, "it cannot be read", "Check the disk");
  if (text->size() > kMaxNameFileBytes) {
    fail_reading(file, "it has more than 4 MiB", "Give a text file with one label a line");
  }
  Result<std::vector<Label>> labels = parse_label_names(*text);
  if (!labels) fail_reading(file, labels.error().text, "Correct the line");
  return *std::move(labels);
}

const SandboxTask kReadNames = answering(
    "read label names", [](const std::string& file) { return packed_values(read_here(file)); });

}  // namespace

std::optional<std::vector<Label>> label_names_from(std::string_view answer) {
  std::vector<Label> labels;
  std::set<double> values;
  const auto is_valid = [&values](const Label& label) {
    return check_member({.series = "labels", .label = label}).has_value() &&
           values.insert(label.value).second;
  };
  if (!unpack_all(answer, labels) || !std::all_of(labels.begin(), labels.end(), is_valid)) {
    return std::nullopt;
  }
  return labels;
}

std::vector<Label> read_label_names(const std::filesystem::path& file) {
  try {
    const std::string answer = run_in_sandbox(kReadNames, {.readable = {file}}, file.string());
    if (auto labels = label_names_from(answer)) return *std::move(labels);
  } catch (const SandboxError& problem) {
    fail_reading(file, problem.what(), "Check the file");
  } catch (const std::runtime_error& problem) {
    throw VolumeFileError(printable(problem.what()));
  }
  fail_reading(file, "its reader does not answer as a reader does", "Check the file");
}

}  // namespace multitetra
