// Data files that a header names by a pattern and numbers ("slice%03d.raw 1 120 1"), and the words
// and numbers in headers that are text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

struct NumberedFiles {
  std::string before;  // The number.
  std::string after;
  std::size_t width = 0;  // A number has at least as many characters, 0 to 10.
  bool zeros = false;     // Whether zeros fill it up, or spaces.
  std::int64_t first = 0;
  std::int64_t step = 1;   // Not 0.
  std::int64_t count = 1;  // 1 to 65536.

  // The number and the name of a file. Require 0 <= index < count; name() that number(index) >= 0.
  [[nodiscard]] std::int64_t number(std::int64_t index) const { return first + index * step; }
  [[nodiscard]] std::string name(std::int64_t index) const;
};

// Whether the text that names data files is a pattern: its first '%' that is not doubled begins the
// conversion of an integer.
[[nodiscard]] bool is_numbered(std::string_view value);

// Reads "<pattern> <first> <last> <step> [<dimension>]"; nullopt unless the pattern has exactly one
// '%', in a conversion such as %d or %03d, and the numbers are those of 1 to 65536 files.
[[nodiscard]] std::optional<NumberedFiles> numbered_files(const std::string& value);

// The names of all of them. Throws VolumeFileError, about the header that has this value, where
// numbered_files gives nullopt or a number is negative.
[[nodiscard]] std::vector<std::string> numbered_names(const std::filesystem::path& header,
                                                      const std::string& value);

// The words between white space.
[[nodiscard]] std::vector<std::string> words_of(const std::string& text);

// The number that all of `text` is; nullopt when it is none.
[[nodiscard]] std::optional<std::int64_t> integer(std::string_view text);
[[nodiscard]] std::optional<double> finite_number(std::string_view text);
// The numbers between white space, commas and brackets; none when a word is no finite number.
[[nodiscard]] std::vector<double> finite_numbers(std::string text);

}  // namespace multitetra
