// Terminal output. Colors are used only on terminals that support them, and not if NO_COLOR is set
// (https://no-color.org).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/utf8.hpp"

namespace multitetra {

enum class Style { kBold, kRed, kYellow };

// Returns whether output to the descriptor, such as STDERR_FILENO, may be colored.
[[nodiscard]] bool has_colors(int descriptor);

// Returns the text in that style if the descriptor supports colors, otherwise unchanged.
[[nodiscard]] std::string styled(Style style, std::string_view text, int descriptor);

// Formats rows of equal length in columns as wide as their widest cells, two spaces apart. No line
// ends with spaces.
[[nodiscard]] std::string text_table(const std::vector<std::vector<std::string>>& rows);

// Collects warnings, each sentence once, and prints them to standard error.
class Notices {
 public:
  explicit Notices(bool is_quiet = false) : is_quiet_(is_quiet) {}  // If quiet, prints nothing.

  void add(const std::string& text);
  void add(const std::vector<std::string>& texts);
  [[nodiscard]] const std::vector<std::string>& texts() const { return texts_; }

 private:
  bool is_quiet_;
  std::vector<std::string> texts_;
};

}  // namespace multitetra
