// Percent-encoding for URLs (RFC 3986).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/base/hex_text.hpp"

namespace multitetra {

// Keeps letters, digits, -._~ and the bytes of `kept`; writes every other byte as %XX.
[[nodiscard]] inline std::string percent_encoded(std::string_view text,
                                                 std::string_view kept = {}) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~";
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string encoded;
  for (const char c : text) {
    if (kPlain.find(c) != std::string_view::npos || kept.find(c) != std::string_view::npos) {
      encoded += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    encoded += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
  }
  return encoded;
}

// Decodes `text`; nullopt if a % is not followed by two hexadecimal digits. Keeps "+", which occurs
// in numbers.
[[nodiscard]] inline std::optional<std::string> percent_decoded(std::string_view text) {
  std::string decoded;
  decoded.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded.push_back(text[i]);
      continue;
    }
    const auto byte = bytes_from_hex(text.substr(i + 1, 2));
    if (!byte || byte->empty()) return std::nullopt;
    decoded.push_back(static_cast<char>(byte->front()));
    i += 2;
  }
  return decoded;
}

}  // namespace multitetra
