// Numbers formatted for people.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

namespace multitetra {

// Returns the shortest decimal that parses to the same number, or "NaN", "infinity", "-infinity".
[[nodiscard]] inline std::string shortest_text(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "infinity" : "-infinity";
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

// Returns at most six significant digits: "0.05", "1e+300".
[[nodiscard]] inline std::string rounded_text(double value) {
  std::array<char, 32> text{};
  const auto digits = std::chars_format::general;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value, digits, 6).ptr};
}

// Returns "1 image", "2 images".
template <typename Count>
[[nodiscard]] std::string counted(Count count, std::string_view noun) {
  return std::to_string(count) + " " + std::string(noun) + (count == 1 ? "" : "s");
}

// Returns "512 x 512 x 234".
template <typename Sides>
[[nodiscard]] std::string sides_text(const Sides& sides) {
  std::string text;
  for (const auto side : sides) text += (text.empty() ? "" : " x ") + std::to_string(side);
  return text;
}

}  // namespace multitetra
