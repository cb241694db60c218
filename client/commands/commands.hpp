// The subcommands of multitetra-client besides `list`. Each function adds one to the program;
// choosing it sets `run`.
#pragma once

#include <functional>

#include "common/cli/command.hpp"

namespace multitetra {

// Returns the exit code. Throws ExitError.
using Run = std::function<int()>;

void add_estimate(Command& program, Run& run);
void add_fetch(Command& program, Run& run);
void add_snapshot(Command& program, Run& run);
void add_view(Command& program, Run& run);

}  // namespace multitetra
