// multitetra-server: makes, prepares and serves volumes.

#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>

#include "server/operations/exit_codes.hpp"
#include "server/service/commands.hpp"

namespace multitetra {
namespace {

int run(int argc, char** argv) {
  CLI::App program("Prepares volumes and serves their isosurfaces: crack-free, coarse first.",
                   "multitetra-server");
  program.set_version_flag("--version", "multitetra-server " MULTITETRA_VERSION);
  program.require_subcommand(1);
  program.footer(
      "Examples:\n"
      "  multitetra-server generate head --size 128 --noise 20 -o head.nrrd\n"
      "  multitetra-server prepare head.nrrd -o head.mtd\n"
      "  multitetra-server serve head.mtd\n"
      "Each command tells more with --help. Exit codes: 0 done, 1 failed, 2 wrong usage.");
  Run command;
  add_generate_command(program, command);
  add_prepare_command(program, command);
  add_info_command(program, command);
  add_verify_command(program, command);
  add_extract_command(program, command);
  add_serve_command(program, command);
  add_token_command(program, command);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? kOk : kUsage;
  }
  return command();
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  try {
    return multitetra::run(argc, argv);
  } catch (const multitetra::ExitError& error) {
    std::cerr << "multitetra-server: " << error.what() << "\n";
    return error.code();
  } catch (const std::exception& error) {
    std::cerr << "multitetra-server: " << error.what() << "\n";
    return multitetra::kFailed;
  }
}
