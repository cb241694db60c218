#include "common/base/parse_number.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

namespace multitetra {
namespace {

std::optional<std::uint64_t> scaled(std::string_view number, std::uint64_t factor) {
  if (const auto whole = parse_number<std::uint64_t>(number)) {
    if (*whole > UINT64_MAX / factor) return std::nullopt;
    return *whole * factor;
  }
  const auto value = parse_number<double>(number);  // "1.5M", "1e6"
  if (!value) return std::nullopt;
  const double product = *value * static_cast<double>(factor);
  const bool is_whole = product >= 0 && product < 0x1p63 && std::trunc(product) == product;
  if (!is_whole) return std::nullopt;
  return static_cast<std::uint64_t>(product);
}

// Returns the letters after the number, in lower case, and the number.
std::pair<std::string, std::string_view> split_unit(std::string_view text) {
  const std::size_t last = text.find_last_of("0123456789.");
  std::string unit(text.substr(last == std::string_view::npos ? 0 : last + 1));
  for (char& c : unit) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return {unit, text.substr(0, text.size() - unit.size())};
}

}  // namespace

std::optional<std::uint64_t> parse_count(std::string_view text) {
  const auto [unit, number] = split_unit(text);
  if (unit.empty()) return scaled(number, 1);
  if (unit == "k") return scaled(number, 1'000);
  if (unit == "m") return scaled(number, 1'000'000);
  return std::nullopt;
}

std::optional<std::uint64_t> parse_bytes(std::string_view text) {
  const auto [unit, number] = split_unit(text);
  if (unit.empty() || unit == "b") return scaled(number, 1);
  const std::size_t power = std::string_view("kmgt").find(unit.front());
  const std::string_view rest = std::string_view(unit).substr(1);
  if (power == std::string_view::npos || !(rest.empty() || rest == "b" || rest == "ib")) {
    return std::nullopt;
  }
  return scaled(number, std::uint64_t{1} << (10 * (power + 1)));
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

std::optional<std::int64_t> integer(std::string_view text) {
  return parse_number<std::int64_t>(text);
}

std::optional<double> finite_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  return parse_finite<double>(text);
}

std::vector<double> finite_numbers(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == ',' || c == '(' || c == ')'; }, ' ');
  std::vector<double> numbers;
  for (const std::string& word : words_of(text)) {
    const std::optional<double> number = finite_number(word);
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace multitetra
