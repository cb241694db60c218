// Numbers from text, where all of the text must be one.
#pragma once

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

namespace multitetra {

// "12", "-3.5e2"; nullopt for anything else, including blanks around it and what does not fit.
// `base` is for integers only.
template <typename Number, typename... Base>
[[nodiscard]] std::optional<Number> parse_number(std::string_view text, Base... base) {
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [rest, code] = std::from_chars(text.data(), end, value, base...);
  if (code != std::errc{} || rest != end) return std::nullopt;
  return value;
}

// "1.5,-2,3e4": `count` numbers with `separator` between them; nullopt for anything else.
template <typename Number>
[[nodiscard]] std::optional<std::vector<Number>> parse_numbers(std::string_view text,
                                                               std::size_t count,
                                                               char separator = ',') {
  std::vector<Number> numbers;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t next = std::min(text.find(separator, at), text.size());
    const auto number = parse_number<Number>(text.substr(at, next - at));
    if (!number || numbers.size() == count) return std::nullopt;
    numbers.push_back(*number);
    at = next + 1;
  }
  if (numbers.size() != count) return std::nullopt;
  return numbers;
}

}  // namespace multitetra
