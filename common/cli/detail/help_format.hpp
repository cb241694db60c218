// Formats --help: examples first, lines that fit a terminal, no names of types.
// --help has the options without a group, --help-all has all by group.
#pragma once

#include <memory>
#include <string>

namespace CLI {
class Formatter;
class Option;
}  // namespace CLI

namespace multitetra {

// The value behind the option's name: "FILE", "on|off"; empty for a flag.
[[nodiscard]] std::string value_text(const CLI::Option& option);

// The option's description, up to the first "; " or ". ", and its default.
[[nodiscard]] std::string short_description(const CLI::Option& option);

// The same with its range and environment.
[[nodiscard]] std::string full_description(const CLI::Option& option);

// The words of `text` in lines of at most `width` characters, longer ones where a word is.
[[nodiscard]] std::string wrapped(const std::string& text, std::size_t width);

[[nodiscard]] std::shared_ptr<CLI::Formatter> help_formatter();

}  // namespace multitetra
