// Conditional requests and ranges (RFC 9110, sections 13 and 14), as far as they concern content
// that never changes under its entity tag. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace multitetra {

// Whether If-None-Match names the tag, `"..."` with its quotes; weak ones count, and "*" names all.
[[nodiscard]] bool names_tag(std::string_view if_none_match, std::string_view tag);

// Bytes of the whole: `length` from `first` on.
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

// The requested range of content of `size` bytes with `tag`. One range is supported; a field that
// is absent, invalid or names several is ignored, and so is one whose If-Range names another tag.
[[nodiscard]] RangeOutcome range_of(std::string_view range, std::string_view if_range,
                                    std::string_view tag, std::uint64_t size);

}  // namespace multitetra
