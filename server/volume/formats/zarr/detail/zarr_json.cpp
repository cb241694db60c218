#include "server/volume/formats/zarr/detail/zarr_json.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

#include "common/base/json.hpp"

namespace multitetra {
namespace {

// Returns the length of the string that begins `text`, with its quotes.
std::size_t string_length(std::string_view text) {
  std::size_t end = 1;
  while (end < text.size() && text[end] != '"') end += text[end] == '\\' ? 2U : 1U;
  return std::min(end + 1, text.size());
}

// Puts the numbers that JSON does not have in quotes.
std::string with_quoted_numbers(std::string_view text) {
  constexpr std::array<std::string_view, 3> kNumbers = {"NaN", "Infinity", "-Infinity"};
  std::string quoted;
  quoted.reserve(text.size());
  while (!text.empty()) {
    const auto* number = std::find_if(kNumbers.begin(), kNumbers.end(), [&](std::string_view name) {
      return text.starts_with(name);
    });
    std::size_t length = text.front() == '"' ? string_length(text) : 1;
    if (number != kNumbers.end()) {
      quoted.append(1, '"').append(*number).append(1, '"');
      length = number->size();
    } else {
      quoted.append(text.substr(0, length));
    }
    text.remove_prefix(length);
  }
  return quoted;
}

}  // namespace

nlohmann::json parse_zarr_json(std::string_view text) {
  nlohmann::json json = parse_json(text);
  return json.is_discarded() ? parse_json(with_quoted_numbers(text)) : json;
}

}  // namespace multitetra
