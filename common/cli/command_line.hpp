// The command line of every program: --version, --help, --help-all, and errors.
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

// The exit code with which the program ends at once: 0 after --help and the like, 2 after a usage
// error, which is printed with the nearest known word. Without arguments a program with subcommands
// prints its help.
[[nodiscard]] std::optional<int> parse_command_line(Command& program, int argc, char** argv);

}  // namespace multitetra
