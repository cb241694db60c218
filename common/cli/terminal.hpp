// What people see on a terminal. Colours are for them alone: none in files and pipes, none where
// NO_COLOR is set (https://no-color.org), none on terminals that have none.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/utf8.hpp"

namespace multitetra {

enum class Style { kBold, kRed, kYellow, kGreen, kDim };

// Whether what is written to the descriptor, as STDERR_FILENO, may be coloured.
[[nodiscard]] bool has_colours(int descriptor);

// The text in that style if the descriptor has colours, else as it is.
[[nodiscard]] std::string styled(Style style, std::string_view text, int descriptor);

// Warnings, printed to the standard error, each sentence once.
class Notices {
 public:
  void tell(const std::string& text);
  void tell(const std::vector<std::string>& texts);
  [[nodiscard]] const std::vector<std::string>& told() const { return told_; }

 private:
  std::vector<std::string> told_;
};

}  // namespace multitetra
