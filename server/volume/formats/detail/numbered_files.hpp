// Data files that a header names by a numbered pattern ("slice%03d.raw 1 120 1"), and helpers for
// words and numbers in text headers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/parse_number.hpp"

namespace multitetra {

struct NumberedFiles {
  std::string before;  // The text before the number.
  std::string after;
  std::size_t width = 0;  // Minimum width of a number, 0 to 10.
  // Pad with zeros instead of spaces.
  bool zeros = false;
  std::int64_t first = 0;
  std::int64_t step = 1;   // Never 0.
  std::int64_t count = 1;  // 1 to 65536.

  // Return the number and the name of a file. Require 0 <= index < count; name() also requires
  // number(index) >= 0.
  [[nodiscard]] std::int64_t number(std::int64_t index) const { return first + index * step; }
  [[nodiscard]] std::string name(std::int64_t index) const;
};

// Returns whether the text is a pattern: its first '%' that is not doubled begins a conversion.
[[nodiscard]] bool is_numbered(std::string_view value);

// Parses "<pattern> <first> <last> <step> [<dimension>]". Returns nullopt unless the pattern has
// exactly one '%', in a conversion such as %d or %03d, and the numbers describe 1 to 65536 files.
[[nodiscard]] std::optional<NumberedFiles> numbered_files(const std::string& value);

// Returns the names of all files. Throws VolumeFileError, naming `header`, if numbered_files()
// returns nullopt or a number is negative.
[[nodiscard]] std::vector<std::string> numbered_names(const std::filesystem::path& header,
                                                      const std::string& value);

}  // namespace multitetra
