// Percent-encoding for URLs (RFC 3986).
#pragma once

#include <string>
#include <string_view>

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

}  // namespace multitetra
