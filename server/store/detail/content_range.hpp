// HTTP byte ranges: the requested one, and the one that a response contains.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace multitetra {

// Bytes first to first + length - 1, or the last `length` bytes if first is kFromEnd.
struct StoreRange {
  static constexpr std::uint64_t kFromEnd = ~std::uint64_t{0};
  std::uint64_t first = 0;
  std::uint64_t length = 0;
};

// The Content-Range header of a response: bytes first to last of `total`.
struct ContentRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;  // At least `first`, and less than `total` if given.
  std::optional<std::uint64_t> total = std::nullopt;

  // Parses "bytes 0-99/1234" and "bytes 0-99/*"; returns nullopt for any other text.
  [[nodiscard]] static std::optional<ContentRange> from(std::string_view text);

  // Returns whether this is the wanted range, possibly cut off at the end of the object.
  [[nodiscard]] bool matches(const StoreRange& wanted) const;
};

}  // namespace multitetra
