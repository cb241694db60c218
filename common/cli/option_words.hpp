// What one option says of itself, in the words that --help, `man` and a shell have in common.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace CLI {
class App;
class Formatter;
class Option;
}  // namespace CLI

namespace multitetra {

// "-o", "--output". None of a positional one.
[[nodiscard]] std::vector<std::string> names_of(const CLI::Option& option);

// The words of which one may follow; none where anything may.
[[nodiscard]] std::vector<std::string> choices_of(const CLI::Option& option);

// What follows the option's name: "FILE", "on|off"; empty for a flag.
[[nodiscard]] std::string value_words(const CLI::Option& option);

// What it is for, as sentences, and behind them default, environment and range.
[[nodiscard]] std::string full_description(const CLI::Option& option);

// The words of `text` in lines of at most `width` characters, longer ones where a word is.
[[nodiscard]] std::string wrapped(const std::string& text, std::size_t width);

// --help with lines that fit on a terminal and without the words of a type system.
[[nodiscard]] std::shared_ptr<CLI::Formatter> help_formatter();

}  // namespace multitetra
