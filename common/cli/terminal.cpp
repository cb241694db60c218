#include "common/cli/terminal.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>

namespace multitetra {
namespace {

const char* code_of(Style style) {
  switch (style) {
    case Style::kBold:
      return "1";
    case Style::kRed:
      return "1;31";
    case Style::kYellow:
      return "33";
  }
  return "0";
}

bool is_set(const char* variable) {
  const char* const value = std::getenv(variable);
  return value != nullptr && *value != '\0';
}

}  // namespace

bool has_colors(int descriptor) {
  const char* const terminal = std::getenv("TERM");
  return isatty(descriptor) == 1 && !is_set("NO_COLOR") && terminal != nullptr &&
         std::string_view(terminal) != "dumb";
}

std::string styled(Style style, std::string_view text, int descriptor) {
  if (!has_colors(descriptor)) return std::string(text);
  return std::string("\033[") + code_of(style) + "m" + std::string(text) + "\033[0m";
}

std::string text_table(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths(rows.front().size());
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += row[i] + std::string(widths[i] - row[i].size() + 2, ' ');
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

void Notices::add(const std::string& text) {
  if (std::find(texts_.begin(), texts_.end(), text) != texts_.end()) return;
  texts_.push_back(text);
  if (is_quiet_) return;
  std::cerr << styled(Style::kYellow, "Notice:", STDERR_FILENO) << " " << printable(text)
            << std::endl;
}

void Notices::add(const std::vector<std::string>& texts) {
  for (const std::string& text : texts) add(text);
}

}  // namespace multitetra
