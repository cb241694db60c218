// Parses numbers that make up the whole text.
#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "common/base/text.hpp"

namespace multitetra {

// Parses "12" or "-3.5e2". Returns nullopt for anything else, including surrounding blanks and
// numbers out of range. `base` is for integers only.
template <typename Number, typename... Base>
[[nodiscard]] std::optional<Number> parse_number(std::string_view text, Base... base) {
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [rest, code] = std::from_chars(text.data(), end, value, base...);
  if (code != std::errc{} || rest != end) return std::nullopt;
  return value;
}

// Parses like parse_number(), but rejects infinities and NaN.
template <typename Number = double>
[[nodiscard]] std::optional<Number> parse_finite(std::string_view text) {
  const std::optional<Number> number = parse_number<Number>(text);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

// Removes and returns the number at the start of `text`. Returns nullopt and leaves `text`
// unchanged if there is none.
template <typename Number>
[[nodiscard]] std::optional<Number> take_number(std::string_view& text) {
  Number value{};
  const auto [rest, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{}) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(rest - text.data()));
  return value;
}

// Parses `min_count` to `max_count` numbers separated by `separator`, such as "1.5,-2,3e4".
template <typename Number>
[[nodiscard]] std::optional<std::vector<Number>> parse_number_list(std::string_view text,
                                                                   std::size_t min_count,
                                                                   std::size_t max_count,
                                                                   char separator = ',') {
  std::vector<Number> numbers;
  for (const std::string_view part : split(text, separator)) {
    const auto number = parse_number<Number>(part);
    if (!number || numbers.size() == max_count) return std::nullopt;
    numbers.push_back(*number);
  }
  if (numbers.size() < min_count) return std::nullopt;
  return numbers;
}

// Parses a list of exactly `count` numbers.
template <typename Number>
[[nodiscard]] std::optional<std::vector<Number>> parse_numbers(std::string_view text,
                                                               std::size_t count,
                                                               char separator = ',') {
  return parse_number_list<Number>(text, count, count, separator);
}

// Parse a whole number with an optional unit of either case: k (1 000) or M for counts such as
// "2M"; B, K, KB, KiB (1 024) and so on up to TiB for bytes such as "500KiB".
[[nodiscard]] std::optional<std::uint64_t> parse_count(std::string_view text);
[[nodiscard]] std::optional<std::uint64_t> parse_bytes(std::string_view text);

// Returns the words between white space.
[[nodiscard]] std::vector<std::string> words_of(const std::string& text);

// Parses the whole text as a number; returns nullopt if it is none.
[[nodiscard]] std::optional<std::int64_t> integer(std::string_view text);
[[nodiscard]] std::optional<double> finite_number(std::string_view text);
// Returns the numbers between white space, commas and brackets; none if a word is no finite number.
[[nodiscard]] std::vector<double> finite_numbers(std::string text);

}  // namespace multitetra
