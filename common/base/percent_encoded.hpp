// Text as a part of an address (RFC 3986).
#pragma once

#include <string>
#include <string_view>

namespace multitetra {

// Letters, digits, -._~ and the bytes of `kept` stay; every other byte is written as %XX.
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
