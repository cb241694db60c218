#include "server/dataset/nrrd_lines.hpp"

#include <algorithm>
#include <array>

#include "common/base/text.hpp"

namespace multitetra {
namespace {

bool is_field(const std::string& line, std::string_view field) {
  return line.starts_with(field) && line.compare(field.size(), 2, ": ") == 0;
}

// `name` as seen from the folder of `file`.
std::string absolute_name(const std::string& name, const std::filesystem::path& file) {
  return (std::filesystem::absolute(file).parent_path() / name).string();
}

}  // namespace

NrrdLines::NrrdLines(std::string_view header) {
  while (!header.empty()) {
    const std::size_t end = std::min(header.find('\n'), header.size());
    std::string line(header.substr(0, end));
    if (line.ends_with('\r')) line.pop_back();
    lines_.push_back(std::move(line));
    header.remove_prefix(std::min(end + 1, header.size()));
  }
}

std::ptrdiff_t NrrdLines::position(std::string_view field) const {
  const auto found = std::find_if(lines_.begin(), lines_.end(),
                                  [&](const std::string& line) { return is_field(line, field); });
  return found == lines_.end() ? -1 : found - lines_.begin();
}

std::optional<std::string> NrrdLines::value(std::string_view field) const {
  const std::ptrdiff_t at = position(field);
  if (at < 0) return std::nullopt;
  return std::string(
      trimmed(std::string_view(lines_[static_cast<std::size_t>(at)]).substr(field.size() + 2)));
}

std::optional<std::string> NrrdLines::key(std::string_view name) const {
  for (const std::string& line : lines_) {
    if (line.starts_with(name) && line.compare(name.size(), 2, ":=") == 0) {
      return line.substr(name.size() + 2);
    }
  }
  return std::nullopt;
}

void NrrdLines::set(std::string_view field, const std::string& value) {
  const std::string line = std::string(field) + ": " + value;
  const std::ptrdiff_t at = position(field);
  if (at < 0) {
    lines_.push_back(line);
  } else {
    lines_[static_cast<std::size_t>(at)] = line;
  }
}

void NrrdLines::remove(std::string_view field) {
  std::erase_if(lines_, [&](const std::string& line) { return is_field(line, field); });
}

void NrrdLines::detach(const std::filesystem::path& file) {
  constexpr std::array<std::string_view, 2> kNames = {"data file", "datafile"};
  const std::size_t header_lines = lines_.size() + 1;  // With the empty line at its end.
  for (const std::string_view field : kNames) {
    const std::ptrdiff_t at = position(field);
    if (at < 0) continue;
    std::string& line = lines_[static_cast<std::size_t>(at)];
    const std::string names = line.substr(field.size() + 2);
    if (names.starts_with("LIST")) {
      for (auto name = lines_.begin() + at + 1; name != lines_.end(); ++name) {
        *name = absolute_name(*name, file);
      }
    } else {
      line = "data file: " + absolute_name(names, file);
    }
    return;
  }
  lines_.push_back("line skip: " + std::to_string(header_lines));
  lines_.push_back("data file: " + std::filesystem::absolute(file).string());
}

std::string NrrdLines::text() const {
  std::string text;
  for (const std::string& line : lines_) text += line + "\n";
  return text;
}

}  // namespace multitetra
