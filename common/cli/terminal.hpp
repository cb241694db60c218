// Terminal output. Colors are used on terminals only: none in files and pipes, none where
// NO_COLOR is set (https://no-color.org), none on terminals that have none.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/utf8.hpp"

namespace multitetra {

enum class Style { kBold, kRed, kYellow };

// Whether what is written to the descriptor, as STDERR_FILENO, may be colored.
[[nodiscard]] bool has_colors(int descriptor);

// The text in that style if the descriptor has colors, else as it is.
[[nodiscard]] std::string styled(Style style, std::string_view text, int descriptor);

// Rows of equally many cells, in columns as wide as their widest cells, two spaces apart. No line
// ends with spaces.
[[nodiscard]] std::string text_table(const std::vector<std::vector<std::string>>& rows);

// Warnings, printed to the standard error, each sentence once.
class Notices {
 public:
  void add(const std::string& text);
  void add(const std::vector<std::string>& texts);
  [[nodiscard]] const std::vector<std::string>& texts() const { return texts_; }

 private:
  std::vector<std::string> texts_;
};

}  // namespace multitetra
