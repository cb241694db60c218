// Colours for people, and only for them: none in files and pipes, none where NO_COLOR is set
// (https://no-color.org), none on terminals that have none.
#pragma once

#include <string>
#include <string_view>

namespace multitetra {

enum class Style { kBold, kRed, kYellow, kGreen, kDim };

// Whether what is written to the descriptor, as STDERR_FILENO, may be coloured.
[[nodiscard]] bool has_colours(int descriptor);

// The text in that style if the descriptor has colours, else as it is.
[[nodiscard]] std::string styled(Style style, std::string_view text, int descriptor);

}  // namespace multitetra
