// The subcommands of multitetra-server. Each adds itself to the program and sets `run` when it was
// chosen.
#pragma once

#include <functional>

#include <CLI/CLI.hpp>

namespace multitetra {

// The command's exit code: 0 done, 1 failed. What is wrong with the world comes as an exception.
using Run = std::function<int()>;

void add_generate_command(CLI::App& program, Run& run);
void add_prepare_command(CLI::App& program, Run& run);
void add_info_command(CLI::App& program, Run& run);
void add_plot_command(CLI::App& program, Run& run);
void add_verify_command(CLI::App& program, Run& run);
void add_extract_command(CLI::App& program, Run& run);
void add_serve_command(CLI::App& program, Run& run);
void add_token_command(CLI::App& program, Run& run);

}  // namespace multitetra
