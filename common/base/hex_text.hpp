// Bytes and numbers as lower-case hexadecimal digits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

// Returns two digits per byte.
[[nodiscard]] inline std::string hex_text(std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const std::byte byte : bytes) {
    text += {kDigits[std::to_integer<unsigned>(byte) >> 4],
             kDigits[std::to_integer<unsigned>(byte) & 15]};
  }
  return text;
}

// Returns sixteen digits, the most significant first.
[[nodiscard]] inline std::string hex_text(std::uint64_t number) {
  std::string text;
  for (int shift = 60; shift >= 0; shift -= 4) text += "0123456789abcdef"[number >> shift & 15];
  return text;
}

// Returns the value of a digit of either case; nullopt for any other character.
[[nodiscard]] inline std::optional<unsigned> value_of_hex_digit(char digit) {
  if (digit >= '0' && digit <= '9') return static_cast<unsigned>(digit - '0');
  if (digit >= 'a' && digit <= 'f') return static_cast<unsigned>(digit - 'a' + 10);
  if (digit >= 'A' && digit <= 'F') return static_cast<unsigned>(digit - 'A' + 10);
  return std::nullopt;
}

// Returns nullopt unless the text consists of pairs of digits.
[[nodiscard]] inline std::optional<std::vector<std::byte>> bytes_from_hex(std::string_view text) {
  if (text.size() % 2 != 0) return std::nullopt;
  std::vector<std::byte> bytes(text.size() / 2);
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto digit = value_of_hex_digit(text[i]);
    if (!digit) return std::nullopt;
    bytes[i / 2] = bytes[i / 2] << 4 | static_cast<std::byte>(*digit);
  }
  return bytes;
}

}  // namespace multitetra
