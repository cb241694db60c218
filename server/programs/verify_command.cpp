#include <iostream>
#include <memory>
#include <string>

#include "common/base/address_text.hpp"
#include "common/base/json.hpp"
#include "common/base/utf8.hpp"
#include "common/cli/human_units.hpp"
#include "common/json/json_report.hpp"
#include "server/dataset/dataset.hpp"
#include "server/dataset/verify_dataset.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/dataset_folder.hpp"
#include "server/programs/progress.hpp"

namespace multitetra {
namespace {

struct VerifyArguments {
  std::string file;
  bool json = false;
  bool quiet = false;
};

// Throws if the dataset is damaged.
Json verify_one(const std::string& place, const VerifyArguments& arguments) {
  Progress progress("verify", 1, arguments.quiet || arguments.json);
  progress.begin("checksums");
  const auto on_progress = [&](double fraction) { progress.update(100 * fraction, 100, "%"); };
  const std::uint64_t bytes = verify_dataset(place, on_progress);
  progress.finish();
  if (!arguments.quiet && !arguments.json) {
    std::cout << printable(without_password(place), /*keeps_lines=*/false)
              << ": all checksums match (" << human_bytes(bytes) << ")\n";
  }
  return {{"file", without_password(place)},
          {"file_bytes", bytes},
          {"is_whole", true},
          {"seconds", progress.seconds()}};
}

int verify_folder(const VerifyArguments& arguments) {
  Json datasets = Json::array();
  std::size_t damaged = 0;
  const ExitCode code = with_each_dataset(
      arguments.file,
      [&](const std::string& place) { datasets.push_back(verify_one(place, arguments)); },
      [&](const std::string& place, const std::string& problem) {
        ++damaged;
        datasets.push_back(
            {{"file", without_password(place)}, {"is_whole", false}, {"error", problem}});
      });
  const std::size_t all = datasets.size();
  if (arguments.json) {
    std::cout << text_of({{"datasets", std::move(datasets)}, {"is_whole", damaged == 0}});
  } else if (!arguments.quiet) {
    std::cout << human_count_of(all, "dataset") << ", " << damaged << " damaged.\n";
  }
  return code;
}

int verify(const VerifyArguments& arguments) {
  if (is_folder_of_datasets(arguments.file)) return verify_folder(arguments);
  const Json report = verify_one(arguments.file, arguments);
  if (arguments.json) std::cout << text_of(report);
  return kOk;
}

}  // namespace

void add_verify_command(Command& program, Run& run) {
  const auto arguments = std::make_shared<VerifyArguments>();
  Command* command = program.add_subcommand(
      "verify", "Check every byte of a dataset; serving checks only what it reads");
  command
      ->add_option("file", arguments->file,
                   "Dataset: a file (.mtd) or the address of a dataset; a local folder or one in a "
                   "bucket: all of its datasets")
      ->required()
      ->type_name("DATASET");
  command->add_flag("--json", arguments->json, "Print a JSON report");
  command->add_flag("--quiet", arguments->quiet, "Print errors only");
  command->footer(
      "Examples:\n"
      "  multitetra-server verify head.mtd\n"
      "  multitetra-server verify s3://volumes/head.mtd\n"
      "  multitetra-server verify datasets/\n"
      "Exit code 0: the dataset is complete. 1: damaged; the message states section and brick.");
  command->callback([arguments, &run] { run = [arguments] { return verify(*arguments); }; });
}

}  // namespace multitetra
