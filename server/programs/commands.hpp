// The subcommands of multitetra-server. Each adds itself to the program and sets `run` when it was
// chosen.
#pragma once

#include <functional>

#include "common/cli/command.hpp"

namespace multitetra {

// The command's exit code: 0 done, 1 failed. What is wrong with the world comes as an exception.
using Run = std::function<int()>;

void add_view_command(Command& program, Run& run);
void add_generate_command(Command& program, Run& run);
void add_prepare_command(Command& program, Run& run);
void add_formats_command(Command& program, Run& run);
void add_info_command(Command& program, Run& run);
void add_plot_command(Command& program, Run& run);
void add_verify_command(Command& program, Run& run);
void add_extract_command(Command& program, Run& run);
void add_certify_command(Command& program, Run& run);
void add_export_command(Command& program, Run& run);
void add_serve_command(Command& program, Run& run);
void add_token_command(Command& program, Run& run);

}  // namespace multitetra
