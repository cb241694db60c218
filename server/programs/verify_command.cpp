#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "common/cli/human_units.hpp"
#include "common/cli/json_report.hpp"
#include "server/dataset/objects/convert_dataset.hpp"
#include "server/dataset/objects/object_dataset.hpp"
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
  const auto tell = [&](double fraction) { progress.update(100 * fraction, 100, "%"); };
  std::uint64_t bytes = 0;
  if (is_object_dataset(arguments.file)) {
    bytes = verify_objects(arguments.file, std::make_shared<ObjectCache>(), tell).bytes;
  } else {
    bytes = std::filesystem::file_size(arguments.file);
    verify_dataset(arguments.file, tell);
  }
  progress.finish();
  if (arguments.json) {
    std::cout << text_of({{"file", arguments.file},
                          {"file_bytes", bytes},
                          {"is_whole", true},
                          {"seconds", progress.seconds()}});
  } else if (!arguments.quiet) {
    std::cout << arguments.file << ": every byte is as it was written (" << human_bytes(bytes)
              << ")\n";
  }
  return 0;
}

}  // namespace

void add_verify_command(Command& program, Run& run) {
  const auto arguments = std::make_shared<VerifyArguments>();
  Command* command = program.add_subcommand(
      "verify", "Check every byte of a dataset; serving checks only what it reads");
  command
      ->add_option("file", arguments->file,
                   "Dataset: a file (.mtd), a folder of objects, or an address of one")
      ->required()
      ->type_name("DATASET");
  command->add_flag("--json", arguments->json, "Print a JSON report");
  command->add_flag("--quiet", arguments->quiet, "Say nothing unless something is wrong");
  command->footer(
      "Examples:\n"
      "  multitetra-server verify head.mtd\n"
      "  multitetra-server verify s3://volumes/head\n"
      "Exit code 0: the dataset is whole. 1: damaged; the message names section and brick.");
  command->callback([arguments, &run] { run = [arguments] { return verify(*arguments); }; });
}

}  // namespace multitetra
