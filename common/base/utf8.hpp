// Validates UTF-8 and makes untrusted text safe to print.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace multitetra {

// Returns the length in bytes of the well-formed UTF-8 sequence at the start of `text`, or 0 (RFC
// 3629: no overlong forms, no surrogates, nothing above U+10FFFF). Requires that `text` is not
// empty.
[[nodiscard]] inline std::size_t utf8_sequence(std::string_view text) {
  const auto byte = [text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
  }
  const bool is_overlong = (lead == 0xE0 && byte(1) < 0xA0) || (lead == 0xF0 && byte(1) < 0x90);
  const bool is_beyond = (lead == 0xED && byte(1) > 0x9F) || (lead == 0xF4 && byte(1) > 0x8F);
  return is_overlong || is_beyond ? 0 : length;
}

// Returns whether the well-formed sequence at the start of `text` could control a terminal or the
// display order, or cannot be in XML: control characters, marks of writing direction, line
// separators and two noncharacters.
[[nodiscard]] inline bool is_control_character(std::string_view text) {
  const auto byte = [text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (byte(0) < 0x20 || byte(0) == 0x7F) return true;
  if (byte(0) == 0xC2) return byte(1) < 0xA0;
  if (byte(0) == 0xD8) return byte(1) == 0x9C;                     // U+061C
  if (byte(0) == 0xEF) return byte(1) == 0xBF && byte(2) >= 0xBE;  // U+FFFE, U+FFFF: not in XML
  if (byte(0) != 0xE2 || (byte(1) != 0x80 && byte(1) != 0x81)) return false;
  if (byte(1) == 0x81) return byte(2) >= 0xA6 && byte(2) <= 0xA9;  // U+2066 to U+2069
  return byte(2) == 0x8E || byte(2) == 0x8F || (byte(2) >= 0xA8 && byte(2) <= 0xAE);
}

// Returns whether `text` is UTF-8 without control characters (see above) and so safe to print.
[[nodiscard]] inline bool is_plain_text(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = utf8_sequence(text);
    if (length == 0 || is_control_character(text)) return false;
    text.remove_prefix(length);
  }
  return true;
}

// Returns `text` with invalid UTF-8 and control characters (see above) written as \xNN. Keeps line
// ends if `keeps_lines`.
[[nodiscard]] inline std::string printable(std::string_view text, bool keeps_lines = true) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string shown;
  while (!text.empty()) {
    const std::size_t length = utf8_sequence(text);
    const bool is_line_end = keeps_lines && text[0] == '\n';
    if (is_line_end || (length > 0 && !is_control_character(text))) {
      shown += text.substr(0, length);
    } else {
      for (const char c : text.substr(0, length > 0 ? length : 1)) {
        const auto byte = static_cast<unsigned char>(c);
        shown += {'\\', 'x', kDigits[byte >> 4], kDigits[byte & 15]};
      }
    }
    text.remove_prefix(length > 0 ? length : 1);
  }
  return shown;
}

}  // namespace multitetra
