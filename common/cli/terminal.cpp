#include "common/cli/terminal.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>

#include "common/base/utf8.hpp"

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
    case Style::kGreen:
      return "32";
    case Style::kDim:
      return "2";
  }
  return "0";
}

bool is_set(const char* variable) {
  const char* const value = std::getenv(variable);
  return value != nullptr && *value != '\0';
}

}  // namespace

bool has_colours(int descriptor) {
  const char* const terminal = std::getenv("TERM");
  return isatty(descriptor) == 1 && !is_set("NO_COLOR") && terminal != nullptr &&
         std::string_view(terminal) != "dumb";
}

std::string styled(Style style, std::string_view text, int descriptor) {
  if (!has_colours(descriptor)) return std::string(text);
  return std::string("\033[") + code_of(style) + "m" + std::string(text) + "\033[0m";
}

std::string printable(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string shown;
  while (!text.empty()) {
    const std::size_t length = utf8_sequence(text);
    const auto first = static_cast<unsigned char>(text[0]);
    const bool is_control = (first < 0x20 && first != '\n') || first == 0x7F ||
                            (first == 0xC2 && static_cast<unsigned char>(text[1]) < 0xA0);
    if (length > 0 && !is_control) {
      shown += text.substr(0, length);
    } else {
      for (const char c : text.substr(0, std::max<std::size_t>(length, 1))) {
        const auto byte = static_cast<unsigned char>(c);
        shown += {'\\', 'x', kDigits[byte >> 4], kDigits[byte & 15]};
      }
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return shown;
}

void Notices::tell(const std::string& text) {
  if (std::find(told_.begin(), told_.end(), text) != told_.end()) return;
  told_.push_back(text);
  std::cerr << styled(Style::kYellow, "Notice:", STDERR_FILENO) << " " << printable(text)
            << std::endl;
}

void Notices::tell(const std::vector<std::string>& texts) {
  for (const std::string& text : texts) tell(text);
}

}  // namespace multitetra
