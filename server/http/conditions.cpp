#include "server/http/conditions.hpp"

#include <algorithm>
#include <charconv>

#include "common/base/text.hpp"

namespace multitetra {
namespace {

std::optional<std::uint64_t> digits(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || end != text.data() + text.size()) return std::nullopt;
  // Larger numbers are equivalent to the maximum.
  return code == std::errc::result_out_of_range ? UINT64_MAX : value;
}

}  // namespace

// Our tags contain no comma. Splitting a foreign tag at a comma cannot produce a match.
bool matches_tag(std::string_view if_none_match, std::string_view tag) {
  if (trimmed(if_none_match) == "*") return true;
  for (std::string_view one : split(if_none_match, ',')) {
    one = trimmed(one);
    if (one.starts_with("W/")) one.remove_prefix(2);
    if (!one.empty() && one == tag) return true;
  }
  return false;
}

RangeOutcome range_of(std::string_view range, std::string_view if_range, std::string_view tag,
                      std::uint64_t size) {
  constexpr std::string_view kUnit = "bytes=";
  if (!range.starts_with(kUnit) || range.find(',') != std::string_view::npos) return FullContent{};
  if (!if_range.empty() && trimmed(if_range) != tag) return FullContent{};
  range = trimmed(range.substr(kUnit.size()));
  const std::size_t dash = range.find('-');
  if (dash == std::string_view::npos) return FullContent{};
  const auto first = digits(range.substr(0, dash));
  const auto last = digits(range.substr(dash + 1));
  if (dash == 0) {  // A suffix of the content.
    if (!last) return FullContent{};
    if (*last == 0 || size == 0) return RangeNotSatisfiable{};
    const std::uint64_t length = std::min(*last, size);
    return ByteRange{size - length, length};
  }
  const bool is_open = dash + 1 == range.size();
  if (!first || (!last && !is_open) || (last && *last < *first)) return FullContent{};
  if (*first >= size) return RangeNotSatisfiable{};
  const std::uint64_t end = is_open ? size - 1 : std::min(*last, size - 1);
  return ByteRange{*first, end - *first + 1};
}

}  // namespace multitetra
