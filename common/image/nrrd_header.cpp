#include "common/image/nrrd_header.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "common/base/text.hpp"

namespace multitetra {
namespace {

// Removes the first line and its line end from `text` and returns it; nullopt if there is none.
std::optional<std::string_view> take_header_line(std::string_view& text) {
  if (text.empty()) return std::nullopt;
  const std::size_t length = std::min(text.find_first_of("\r\n"), text.size());
  const std::string_view line = text.substr(0, length);
  text.remove_prefix(length);
  text.remove_prefix(text.starts_with("\r\n") ? 2 : std::min<std::size_t>(1, text.size()));
  return line;
}

// Returns the field's name in lower case; of two spellings the one with a space.
std::string field_name(std::string_view written) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kSpellings = {
      {{"datafile", "data file"},
       {"lineskip", "line skip"},
       {"byteskip", "byte skip"},
       {"axismins", "axis mins"},
       {"axismaxs", "axis maxs"},
       {"centerings", "centers"}}};
  std::string name = lower_case(written);
  for (const auto& [other, canonical] : kSpellings) {
    if (name == other) name = canonical;
  }
  return name;
}

void add_line(std::string_view line, NrrdHeader& header) {
  if (line.starts_with('#')) return;
  const std::size_t key_end = line.find(":=");
  const std::size_t field_end = line.find(": ");
  if (key_end < field_end) {
    header.keys[std::string(line.substr(0, key_end))] = line.substr(key_end + 2);
  } else if (field_end != std::string_view::npos) {
    header.fields[field_name(line.substr(0, field_end))] = trimmed(line.substr(field_end + 2));
  }
}

std::string value_in(const std::map<std::string, std::string, std::less<>>& values,
                     std::string_view name) {
  const auto found = values.find(name);
  return found == values.end() ? std::string() : found->second;
}

}  // namespace

std::string NrrdHeader::field(std::string_view name) const { return value_in(fields, name); }

std::string NrrdHeader::key(std::string_view name) const { return value_in(keys, name); }

std::vector<std::string> NrrdHeader::axis_words(std::string_view name, std::size_t axes) const {
  std::vector<std::string> words;
  const std::string all = field(name);
  for (std::string_view value = trimmed(all); !value.empty(); value = trimmed(value)) {
    const char end_mark = value[0] == '(' ? ')' : value[0] == '"' ? '"' : ' ';
    const std::size_t found = value.find(end_mark, 1);
    const std::size_t length = found == std::string_view::npos ? value.size()
                               : end_mark == ' '               ? found
                                                               : found + 1;
    words.emplace_back(value.substr(0, length));
    value.remove_prefix(length);
  }
  if (words.size() != axes) words.clear();
  return words;
}

NrrdHeader parse_nrrd_header(std::string_view text) {
  NrrdHeader header;
  std::string_view rest = text;
  while (const std::optional<std::string_view> line = take_header_line(rest)) {
    header.has_end = line->empty();
    if (header.has_end) break;
    header.text.append(*line).append("\n");
    if (header.field("data file").starts_with("LIST")) {
      header.listed_files.emplace_back(*line);
    } else {
      add_line(*line, header);
    }
  }
  header.bytes = text.size() - rest.size();
  return header;
}

}  // namespace multitetra
