// What all our programs do alike with a command line: --version, --help, --completion, --man, and
// what is said when it is wrong.
//
//   CLI::App app("Does this and that.", "multitetra-this");
//   add_program_flags(app);
//   ...
//   if (const auto code = parse_command_line(app, argc, argv)) return *code;
#pragma once

#include <functional>
#include <optional>

#include <CLI/CLI.hpp>

namespace multitetra {

// To be called before subcommands are added, which take over how help is written.
void add_program_flags(CLI::App& app);

// The code with which the program ends at once: 0 after --help and the like, 2 when the line is
// wrong, which is then told together with what was perhaps meant. Without any word a program that
// has subcommands prints its help.
[[nodiscard]] std::optional<int> parse_command_line(CLI::App& app, int argc, char** argv);

// The option or subcommand that is most like a word that nobody knows; empty when none is near.
[[nodiscard]] std::string nearest_word(const CLI::App& app, const std::string& word);

}  // namespace multitetra
