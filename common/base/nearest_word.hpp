// The known word most similar to an unknown one, for "did you mean".
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace multitetra {

// Returns the word with the smallest edit distance, or that begins with `word`; empty if too
// distant.
[[nodiscard]] std::string nearest_word(std::string_view word, std::span<const std::string> known);

// Returns " Did you mean "NEAREST"?" for an error message; empty if no word is similar.
[[nodiscard]] std::string did_you_mean(std::string_view word, std::span<const std::string> known);

}  // namespace multitetra
