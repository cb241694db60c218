// The subcommands of multitetra-server. Each function adds one to the program; choosing it sets
// `run`.
#pragma once

#include <functional>

#include "common/cli/command.hpp"

namespace multitetra {

// Returns the exit code: 0 success, 1 failure. Throws for external errors.
using Run = std::function<int()>;

void add_view_command(Command& program, Run& run);
void add_generate_command(Command& program, Run& run);
void add_prepare_command(Command& program, Run& run);
void add_formats_command(Command& program, Run& run);
void add_info_command(Command& program, Run& run);
void add_plot_command(Command& program, Run& run);
void add_verify_command(Command& program, Run& run);
void add_extract_command(Command& program, Run& run);
void add_reference_command(Command& program, Run& run);
void add_certify_command(Command& program, Run& run);
void add_export_command(Command& program, Run& run);
void add_serve_command(Command& program, Run& run);
void add_token_command(Command& program, Run& run);

}  // namespace multitetra
