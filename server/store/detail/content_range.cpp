#include "server/store/detail/content_range.hpp"

#include <algorithm>

#include "common/base/parse_number.hpp"

namespace multitetra {

std::optional<ContentRange> ContentRange::from(std::string_view text) {
  constexpr std::string_view kUnit = "bytes ";
  if (!text.starts_with(kUnit)) return std::nullopt;
  text.remove_prefix(kUnit.size());
  ContentRange range;
  const auto take = [&text](std::uint64_t& into, char end) {
    const auto number = take_number<std::uint64_t>(text);
    if (!number) return false;
    into = *number;
    if (end == '\0') return text.empty();
    if (!text.starts_with(end)) return false;
    text.remove_prefix(1);
    return true;
  };
  if (!take(range.first, '-') || !take(range.last, '/')) return std::nullopt;
  if (text != "*" && !take(range.total.emplace(), '\0')) return std::nullopt;
  // With a last byte of 2^64 - 1, the length of the full range would overflow to 0.
  if (range.first > range.last || range.last == ~std::uint64_t{0}) return std::nullopt;
  if (range.total && range.last >= *range.total) return std::nullopt;
  return range;
}

bool ContentRange::matches(const StoreRange& wanted) const {
  if (wanted.first == StoreRange::kFromEnd) {
    return total && last + 1 == *total && last - first + 1 == std::min(wanted.length, *total);
  }
  const std::uint64_t end = wanted.first + wanted.length;
  return first == wanted.first && last < end && (last + 1 == end || total == last + 1);
}

}  // namespace multitetra
