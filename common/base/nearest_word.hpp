// The known word nearest to an unknown one, for "did you mean".
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace multitetra {

// The known word with the smallest edit distance, or that begins with `word`; empty where none is
// near.
[[nodiscard]] std::string nearest_word(std::string_view word, std::span<const std::string> known);

// " Did you mean "NEAREST"?", to be appended to an error; empty where none is near.
[[nodiscard]] std::string did_you_mean(std::string_view word, std::span<const std::string> known);

}  // namespace multitetra
