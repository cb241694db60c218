#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "common/cli/human_units.hpp"
#include "common/cli/json_report.hpp"
#include "server/dataset/verify_dataset.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/progress.hpp"

namespace multitetra {
namespace {

struct VerifyArguments {
  std::string file;
  bool json = false;
  bool quiet = false;
};

int verify(const VerifyArguments& arguments) {
  Progress progress("verify", 1, arguments.quiet || arguments.json);
  progress.begin("checksums");
  const auto bytes = static_cast<double>(std::filesystem::file_size(arguments.file));
  verify_dataset(arguments.file,
                 [&](double fraction) { progress.update(fraction * bytes, bytes, "bytes"); });
  progress.finish();
  if (arguments.json) {
    std::cout << text_of({{"file", arguments.file},
                          {"file_bytes", static_cast<std::uint64_t>(bytes)},
                          {"is_whole", true},
                          {"seconds", progress.seconds()}});
  } else if (!arguments.quiet) {
    std::cout << arguments.file << ": every byte is as it was written ("
              << human_bytes(static_cast<std::uint64_t>(bytes)) << ")\n";
  }
  return 0;
}

}  // namespace

void add_verify_command(Command& program, Run& run) {
  const auto arguments = std::make_shared<VerifyArguments>();
  Command* command = program.add_subcommand(
      "verify", "Check every byte of a dataset file; serving checks only what it reads");
  command->add_option("file", arguments->file, "Dataset file (.mtd)")
      ->required()
      ->type_name("FILE");
  command->add_flag("--json", arguments->json, "Print a JSON report");
  command->add_flag("--quiet", arguments->quiet, "Say nothing unless something is wrong");
  command->footer(
      "Examples:\n"
      "  multitetra-server verify head.mtd\n"
      "Exit code 0: the file is whole. 1: damaged; the message names section and brick.");
  command->callback([arguments, &run] { run = [arguments] { return verify(*arguments); }; });
}

}  // namespace multitetra
