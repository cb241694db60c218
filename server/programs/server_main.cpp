// multitetra-server: prepares and serves volumes.
#include "common/cli/command_line.hpp"
#include "common/cli/program.hpp"
#include "common/sandbox/sandbox.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/serving/listener_options.hpp"

namespace multitetra {
namespace {

int run(int argc, char** argv) {
  Command program(
      "Prepares volumes and serves their isosurfaces as watertight meshes, coarse first.",
      "multitetra-server");
  add_program_flags(program);
  program.require_subcommand();
  program.footer(
      "Examples:\n"
      "  multitetra-server view head.nrrd\n"
      "  multitetra-server prepare head.nrrd -o head.mtd\n"
      "  multitetra-server serve head.mtd\n"
      "Each command has its own --help. Exit codes: 0 done, 1 failed, 2 wrong usage; some have "
      "more.");
  Run command;
  add_view_command(program, command);
  add_generate_command(program, command);
  add_prepare_command(program, command);
  add_formats_command(program, command);
  add_info_command(program, command);
  add_plot_command(program, command);
  add_verify_command(program, command);
  add_extract_command(program, command);
  add_reference_command(program, command);
  add_certify_command(program, command);
  add_export_command(program, command);
  add_serve_command(program, command);
  add_token_command(program, command);
  if (const auto code = parse_command_line(program, argc, argv)) return *code;
  return command();
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  multitetra::enter_sandbox_if_asked(argc, argv);
  return multitetra::run_program(
      "multitetra-server", [&] { return multitetra::run(argc, argv); },
      multitetra::print_fatal_error);
}
