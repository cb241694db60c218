#include "server/dataset/nrrd_header.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <fstream>
#include <vector>

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxNrrdHeaderBytes = std::size_t{1} << 20;

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string line(text.substr(0, end));
    if (line.ends_with('\r')) line.pop_back();
    lines.push_back(std::move(line));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

bool is_field(const std::string& line, std::string_view field) {
  return line.starts_with(field) && line.compare(field.size(), 2, ": ") == 0;
}

std::ptrdiff_t position_of(const std::vector<std::string>& lines, std::string_view field) {
  const auto found = std::find_if(lines.begin(), lines.end(),
                                  [&](const std::string& line) { return is_field(line, field); });
  return found == lines.end() ? -1 : found - lines.begin();
}

// `name` as seen from the folder of `file`.
std::string absolute_name(const std::string& name, const fs::path& file) {
  return (fs::absolute(file).parent_path() / name).string();
}

// Makes the data file names absolute; an attached header becomes a detached one that skips itself.
void detach(std::vector<std::string>& lines, const fs::path& file) {
  constexpr std::array<std::string_view, 2> kNames = {"data file", "datafile"};
  const std::size_t header_lines = lines.size() + 1;  // With the empty line at its end.
  for (const std::string_view field : kNames) {
    const std::ptrdiff_t at = position_of(lines, field);
    if (at < 0) continue;
    std::string& line = lines[static_cast<std::size_t>(at)];
    const std::string names = line.substr(field.size() + 2);
    if (names.starts_with("LIST")) {
      for (auto name = lines.begin() + at + 1; name != lines.end(); ++name) {
        *name = absolute_name(*name, file);
      }
    } else {
      line = "data file: " + absolute_name(names, file);
    }
    return;
  }
  lines.push_back("line skip: " + std::to_string(header_lines));
  lines.push_back("data file: " + fs::absolute(file).string());
}

}  // namespace

std::optional<std::string> rewritten_nrrd_header(std::string_view header, const fs::path& file) {
  std::vector<std::string> lines = lines_of(header);
  if (lines.empty() || !lines[0].starts_with("NRRD")) return std::nullopt;
  const std::ptrdiff_t named = position_of(lines, "space");
  const std::ptrdiff_t space = named >= 0 ? named : position_of(lines, "space dimension");
  const std::ptrdiff_t directions = position_of(lines, "space directions");
  const std::ptrdiff_t origin = position_of(lines, "space origin");
  const bool only_spacings = space >= 0 && directions < 0 && position_of(lines, "spacings") >= 0;
  const bool too_late = (directions >= 0 && directions < space) || (origin >= 0 && origin < space);
  const bool missing = space < 0 && (directions >= 0 || origin >= 0);
  if (!only_spacings && !too_late && !missing) return std::nullopt;

  detach(lines, file);
  if (only_spacings) {
    lines.erase(lines.begin() + space);
    std::erase_if(lines, [](const std::string& line) { return is_field(line, "space origin"); });
  } else if (missing) {
    lines.insert(lines.begin() + 1, "space dimension: 3");
  } else {
    std::rotate(lines.begin() + 1, lines.begin() + space, lines.begin() + space + 1);
  }
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

std::string read_nrrd_header(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string header;
  std::string line;
  while (header.size() < kMaxNrrdHeaderBytes && std::getline(in, line)) {
    if (line.empty() || line == "\r") break;
    header += line + "\n";
  }
  return header;
}

}  // namespace multitetra
