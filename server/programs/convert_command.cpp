#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

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
#include "server/store/http_store.hpp"

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

// The dataset files of a folder, by name; empty: the input is none, or one of objects.
std::vector<std::filesystem::path> files_in(const std::string& input) {
  std::vector<std::filesystem::path> files;
  if (is_address(input) || is_object_dataset(input) || !std::filesystem::is_directory(input)) {
    return files;
  }
  for (const auto& entry : std::filesystem::directory_iterator(input)) {
    if (entry.path().extension() == ".mtd") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  if (files.empty()) {
    throw ExitError(kUsage, input + ": there is no dataset file (.mtd) in this folder.");
  }
  return files;
}

// A folder of files, such as a family, becomes a store: a folder of objects that all of them share,
// and a folder for each with its manifest.
int convert_to_store(const ConvertArguments& arguments,
                     const std::vector<std::filesystem::path>& files) {
  if (std::filesystem::path(arguments.output).extension() == ".mtd") {
    throw ExitError(kUsage, "--output: files become a store, whose name does not end in .mtd.");
  }
  if (is_object_dataset(arguments.output)) {
    throw ExitError(kUsage, "--output: " + arguments.output +
                                " is a dataset; several become a store, a folder of its own.");
  }
  check_folder(arguments);
  Progress progress("convert", files.size(), arguments.quiet || arguments.json);
  const auto tell = [&](double fraction) { progress.update(100 * fraction, 100, "%"); };
  Json datasets = Json::array();
  std::uint64_t all = 0;
  std::uint64_t added = 0;
  for (const std::filesystem::path& file : files) {
    const std::string name = file.stem().string();
    progress.begin(name);
    const ConvertedObjects converted =
        file_to_shared_objects(file, std::filesystem::path(arguments.output) / name, tell);
    all += converted.bytes;
    added += converted.new_bytes;
    datasets.push_back({{"name", name},
                        {"objects", converted.objects},
                        {"object_bytes", converted.bytes},
                        {"new_bytes", converted.new_bytes}});
  }
  const std::uint64_t removed =
      arguments.remove_others ? remove_unused_objects(arguments.output) : 0;
  progress.finish();
  if (arguments.json) {
    std::cout << text_of({{"input", arguments.input},
                          {"output", arguments.output},
                          {"datasets", datasets},
                          {"object_bytes", all},
                          {"new_bytes", added},
                          {"removed_bytes", removed},
                          {"seconds", progress.seconds()}});
  } else if (!arguments.quiet) {
    std::cout << arguments.output << ": " << human_count_of(files.size(), "dataset") << " of "
              << human_bytes(all) << ", " << human_bytes(added) << " of them new in the store"
              << (arguments.remove_others ? "; " + human_bytes(removed) + " removed" : "") << "\n"
              << "Next: multitetra-server serve " << arguments.output << "\n";
  }
  return kOk;
}

int convert(const ConvertArguments& arguments) {
  if (const auto files = files_in(arguments.input); !files.empty()) {
    return convert_to_store(arguments, files);
  }
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
      "convert", "Turn dataset files into folders of immutable objects, or back");
  command
      ->add_option("input", a->input,
                   "Dataset file (.mtd); a folder of them, such as a family, which share their "
                   "objects then; or a dataset made of objects: a folder, an address (https://, "
                   "s3://bucket/path)")
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
      "  multitetra-server convert heart/ -o store/    # store/objects, store/heart.t0000, ...\n"
      "What is converted and converted back is the same file, bit for bit.");
  command->callback([a, &run] { run = [a] { return convert(*a); }; });
}

}  // namespace multitetra
