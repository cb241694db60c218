#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "common/base/exit_codes.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/json_report.hpp"
#include "common/cli/output_files.hpp"
#include "server/dataset/objects/convert_dataset.hpp"
#include "server/dataset/objects/object_dataset.hpp"
#include "server/dataset/section_table.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/progress.hpp"

namespace multitetra {
namespace {

struct ConvertArguments {
  std::string input;
  std::string output;
  bool remove_others = false;
  bool force = false;
  bool json = false;
  bool quiet = false;
};

// Throws unless the folder may take objects: it is not there, is empty, or has a dataset already.
void check_folder(const ConvertArguments& arguments) {
  const std::filesystem::path folder = arguments.output;
  if (!std::filesystem::exists(folder)) return;
  if (!std::filesystem::is_directory(folder)) {
    throw ExitError(kUsage, "--output: " + arguments.output +
                                " is a file; a name that does not end in .mtd is one of a folder.");
  }
  if (arguments.force || is_object_dataset(arguments.output) || std::filesystem::is_empty(folder) ||
      std::filesystem::exists(folder / "objects")) {
    return;
  }
  throw ExitError(kUsage, "--output: " + arguments.output +
                              " has other things in it than a dataset; --force adds one.");
}

void check_file(const ConvertArguments& arguments) {
  const std::filesystem::path file = arguments.output;
  require_outputs({{"--output", file}}, {});
  if (arguments.force || !std::filesystem::exists(file) || begins_as_dataset(file)) return;
  throw ExitError(kUsage, "--output: " + arguments.output +
                              " is there already and no dataset; --force replaces it.");
}

int convert(const ConvertArguments& arguments) {
  Progress progress("convert", 1, arguments.quiet || arguments.json);
  const auto tell = [&](double fraction) { progress.update(100 * fraction, 100, "%"); };
  Json report = {{"input", arguments.input}, {"output", arguments.output}};
  std::string facts;
  if (is_object_dataset(arguments.input)) {
    if (std::filesystem::path(arguments.output).extension() != ".mtd") {
      throw ExitError(kUsage, "--output: objects become a file, whose name ends in .mtd.");
    }
    check_file(arguments);
    progress.begin("file");
    objects_to_file(arguments.input, std::make_shared<ObjectCache>(), arguments.output, tell);
    const std::uint64_t bytes = std::filesystem::file_size(arguments.output);
    report["file_bytes"] = bytes;
    facts = human_bytes(bytes);
  } else {
    if (std::filesystem::path(arguments.output).extension() == ".mtd") {
      throw ExitError(kUsage,
                      "--output: a file becomes a folder, whose name does not end in .mtd.");
    }
    check_folder(arguments);
    progress.begin("objects");
    const ConvertedObjects converted =
        file_to_objects(arguments.input, arguments.output, arguments.remove_others, tell);
    report["objects"] = converted.objects;
    report["object_bytes"] = converted.bytes;
    report["removed_bytes"] = converted.removed_bytes;
    facts = human_count(converted.objects) + " objects, " + human_bytes(converted.bytes);
    if (arguments.remove_others) {
      facts += "; " + human_bytes(converted.removed_bytes) + " of other versions removed";
    }
  }
  progress.finish();
  report["seconds"] = progress.seconds();
  if (arguments.json) {
    std::cout << text_of(report);
  } else if (!arguments.quiet) {
    std::cout << arguments.output << ": " << facts << "\n"
              << "Next: multitetra-server serve " << arguments.output << "\n";
  }
  return kOk;
}

}  // namespace

void add_convert_command(Command& program, Run& run) {
  const auto a = std::make_shared<ConvertArguments>();
  Command* command = program.add_subcommand(
      "convert", "Turn a dataset file into a folder of immutable objects, or back");
  command
      ->add_option("input", a->input,
                   "Dataset file (.mtd), or a dataset made of objects: a folder, an address "
                   "(https://, s3://bucket/path)")
      ->required()
      ->type_name("DATASET");
  command
      ->add_option("-o,--output", a->output,
                   "A folder for the objects of a file; a file (.mtd) for what was objects")
      ->required()
      ->type_name("PLACE");
  command->add_flag("--remove-others", a->remove_others,
                    "Remove objects in the folder that this version does not have; servers that "
                    "have another version open lose it");
  command->add_flag("--force", a->force, "Also over a file, or into a folder, of something else");
  command->add_flag("--json", a->json, "Print a JSON report");
  command->add_flag("--quiet", a->quiet, "Say nothing unless something is wrong");
  command->footer(
      "Examples:\n"
      "  multitetra-server convert head.mtd -o head\n"
      "  aws s3 sync head/objects s3://volumes/head/objects && aws s3 cp head/manifest.json "
      "s3://volumes/head/\n"
      "  multitetra-server convert s3://volumes/head -o head.mtd\n"
      "What is converted and converted back is the same file, bit for bit.");
  command->callback([a, &run] { run = [a] { return convert(*a); }; });
}

}  // namespace multitetra
