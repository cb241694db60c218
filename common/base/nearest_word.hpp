// The known word most similar to an unknown one, for "did you mean".
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

// Returns the word with the smallest edit distance, or that begins with `word`; empty if too
// distant.
[[nodiscard]] std::string nearest_word(std::string_view word, std::span<const std::string> known);

// Returns three of the words in quotes, those nearest to `word` first, and how many
// more there are: "\"a\", \"b\", \"c\" and 199 more"; all if there are at most four.
[[nodiscard]] std::string few_of(std::string_view word, std::vector<std::string> known);

// Returns " Did you mean "NEAREST"?" for an error message; empty if no word is similar.
[[nodiscard]] std::string did_you_mean(std::string_view word, std::span<const std::string> known);

}  // namespace multitetra
