// Ranges of bytes as HTTP has them: what is asked for, and what an answer says that it is.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace multitetra {

// Bytes first ... first + length - 1, or the last `length` ones where first is kFromEnd.
struct ByteRange {
  static constexpr std::uint64_t kFromEnd = ~std::uint64_t{0};
  std::uint64_t first = 0;
  std::uint64_t length = 0;
};

// The header Content-Range of an answer: bytes first ... last of `total`.
struct ContentRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;  // At least `first`; below `total` where that is given.
  std::optional<std::uint64_t> total = std::nullopt;

  // Reads "bytes 0-99/1234" and "bytes 0-99/*"; nullopt when it is no such thing.
  [[nodiscard]] static std::optional<ContentRange> from(std::string_view text);

  // Whether it is what was wanted, cut off at the end of the whole at most.
  [[nodiscard]] bool is(const ByteRange& wanted) const;
};

}  // namespace multitetra
