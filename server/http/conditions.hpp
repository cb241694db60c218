// Conditional requests and ranges (RFC 9110, sections 13 and 14) for content that is immutable
// under its entity tag. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace multitetra {

// Returns whether If-None-Match contains the quoted tag. Weak tags match too, and "*" matches all.
[[nodiscard]] bool matches_tag(std::string_view if_none_match, std::string_view tag);

struct ByteRange {
  std::uint64_t first = 0;
  std::uint64_t length = 0;

  friend bool operator==(const ByteRange&, const ByteRange&) = default;
};
struct RangeNotSatisfiable {
  friend bool operator==(const RangeNotSatisfiable&, const RangeNotSatisfiable&) = default;
};
struct FullContent {
  friend bool operator==(const FullContent&, const FullContent&) = default;
};
using RangeOutcome = std::variant<FullContent, ByteRange, RangeNotSatisfiable>;

// Returns the requested range of content of `size` bytes with `tag`. Supports one range. Ignores a
// field that is absent, invalid or has several ranges, and any field whose If-Range has another
// tag.
[[nodiscard]] RangeOutcome range_of(std::string_view range, std::string_view if_range,
                                    std::string_view tag, std::uint64_t size);

}  // namespace multitetra
