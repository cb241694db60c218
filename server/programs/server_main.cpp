// multitetra-server: makes, prepares and serves volumes.
#include <unistd.h>

#include <exception>
#include <iostream>

#include "common/base/exit_codes.hpp"
#include "common/cli/command_line.hpp"
#include "common/cli/terminal.hpp"
#include "server/programs/commands.hpp"

namespace multitetra {
namespace {

int run(int argc, char** argv) {
  Command program("Prepares volumes and serves their isosurfaces: crack-free, coarse first.",
                  "multitetra-server");
  add_program_flags(program);
  program.require_subcommand();
  program.footer(
      "Examples:\n"
      "  multitetra-server generate head --size 128 --noise 20 -o head.nrrd\n"
      "  multitetra-server prepare head.nrrd -o head.mtd\n"
      "  multitetra-server serve head.mtd\n"
      "Each command tells more with --help. Exit codes: 0 done, 1 failed, 2 wrong usage.");
  Run command;
  add_generate_command(program, command);
  add_prepare_command(program, command);
  add_formats_command(program, command);
  add_info_command(program, command);
  add_plot_command(program, command);
  add_verify_command(program, command);
  add_extract_command(program, command);
  add_serve_command(program, command);
  add_token_command(program, command);
  if (const auto code = parse_command_line(program, argc, argv)) return *code;
  return command();
}

}  // namespace
}  // namespace multitetra

namespace {

int complain(int code, const char* text) {
  using multitetra::Style;
  std::cerr << multitetra::styled(Style::kRed, "multitetra-server:", STDERR_FILENO) << " " << text
            << "\n";
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return multitetra::run(argc, argv);
  } catch (const multitetra::ExitError& error) {
    return complain(error.code(), error.what());
  } catch (const std::exception& error) {
    return complain(multitetra::kFailed, error.what());
  }
}
