// Formats help texts: examples first, lines that fit a terminal, no type names. --help prints the
// options without a group, --help-all prints all by group.
#pragma once

#include <memory>
#include <string>

namespace CLI {
class Formatter;
class Option;
}  // namespace CLI

namespace multitetra {

// Returns the value shown after the option's name: "FILE", "on|off"; empty for a flag.
[[nodiscard]] std::string value_text(const CLI::Option& option);

// Returns the option's description up to the first "; " or ". " outside of parentheses, and its
// default.
[[nodiscard]] std::string short_description(const CLI::Option& option);

// Returns the full description with range, default and environment variable.
[[nodiscard]] std::string full_description(const CLI::Option& option);

// Wraps `text` at `width` characters; longer words get their own line.
[[nodiscard]] std::string wrapped(const std::string& text, std::size_t width);

[[nodiscard]] std::shared_ptr<CLI::Formatter> help_formatter();

}  // namespace multitetra
