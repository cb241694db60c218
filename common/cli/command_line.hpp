// Parses the command line of every program: --version, --help, --help-all, and errors.
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

// Call before adding subcommands, which inherit the help formatter.
void add_program_flags(Command& program);

// Returns an exit code if the program must end now: 0 after --help and the like, 2 after a usage
// error, which is printed with the most similar known word. Without arguments, prints the help of
// programs with subcommands.
[[nodiscard]] std::optional<int> parse_command_line(Command& program, int argc, char** argv);

}  // namespace multitetra
