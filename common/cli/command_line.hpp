// What all our programs do alike with a command line: --version, --help, --completion, --man, and
// what is said when it is wrong.
//
//   Command program("Does this and that.", "multitetra-this");
//   add_program_flags(program);
//   ...
//   if (const auto code = parse_command_line(program, argc, argv)) return *code;
#pragma once

#include <optional>
#include <string>

#include "common/cli/command.hpp"

namespace multitetra {

// To be called before subcommands are added, which take over how help is written.
void add_program_flags(Command& program);

// The code with which the program ends at once: 0 after --help and the like, 2 when the line is
// wrong, which is then told together with what was perhaps meant. Without any word a program that
// has subcommands prints its help.
[[nodiscard]] std::optional<int> parse_command_line(Command& program, int argc, char** argv);

}  // namespace multitetra
