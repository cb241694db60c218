#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

#include "common/base/exit_codes.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/json_report.hpp"
#include "common/cli/output_files.hpp"
#include "server/dataset/prepare.hpp"
#include "server/dataset/section_table.hpp"
#include "server/dataset/source_note.hpp"
#include "server/dataset/volume_files.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/progress.hpp"
#include "server/programs/thread_options.hpp"
#include "server/programs/volume_options.hpp"

namespace multitetra {
namespace {

struct PrepareArguments {
  std::string input;
  std::string output;
  std::string name;
  std::string outside = "void";
  std::int32_t margin = 0;
  VolumeOptions volume;
  int bins = IsovalueBins::kDefaultCount;
  int threads = 0;
  bool force = false;
  bool json = false;
  bool quiet = false;
};

// "void" or a number.
std::optional<double> outside_value(const std::string& text) {
  if (text == "void") return std::nullopt;
  try {
    std::size_t used = 0;
    const double value = std::stod(text, &used);
    if (used == text.size() && std::isfinite(value)) return value;
  } catch (const std::exception&) {  // Told below.
  }
  throw std::invalid_argument("--outside is \"" + text + "\"; it must be void or a finite number.");
}

// The file's name without its suffixes: "chris_t1.nii.gz" is chris_t1.
std::string default_name(const std::filesystem::path& input) {
  std::filesystem::path name =
      input.filename().empty() ? input.parent_path().filename() : input.filename();
  if (name.extension() == ".gz") name = name.stem();
  return name.stem().string();
}

// Throws unless the dataset may take this name: what is there may be nobody's but an older
// dataset's, and the input's in no case.
void check_output(const PrepareArguments& arguments) {
  const std::filesystem::path output = arguments.output;
  require_outputs({{"--output", output}}, {{"input", arguments.input}});
  if (arguments.force) return;
  if (output.extension() != ".mtd") {
    throw ExitError(kUsage, "--output: the name of a dataset ends in .mtd, and \"" +
                                arguments.output + "\" does not; --force takes it all the same.");
  }
  if (std::filesystem::exists(output) && std::filesystem::file_size(output) > 0 &&
      !begins_as_dataset(output)) {
    throw ExitError(kUsage, "--output: " + arguments.output +
                                " is there already and no dataset; --force replaces it.");
  }
}

int prepare(const PrepareArguments& arguments) {
  const ThreadLimit limit(arguments.threads);
  check_output(arguments);
  const std::optional<double> outside = outside_value(arguments.outside);
  const std::string dataset_name =
      arguments.name.empty() ? default_name(arguments.input) : arguments.name;
  Progress progress("prepare", 3, arguments.quiet || arguments.json);
  progress.begin("open");
  VolumeFileOptions options = arguments.volume.parsed();
  options.notice = [&](const std::string& text) { progress.note(text); };
  const auto source = open_volume(arguments.input, options);
  const SourceNote note = source_note(arguments.input);
  std::string pass;
  const DatasetInfo info =
      prepare(*source,
              {.name = dataset_name,
               .outside = outside,
               .margin = arguments.margin,
               .bins = arguments.bins,
               .progress =
                   [&](const char* name, std::uint64_t done, std::uint64_t all) {
                     if (pass != name) progress.begin(pass = name);
                     progress.update(static_cast<double>(done), static_cast<double>(all), "voxels");
                   }},
              arguments.output, note);
  progress.finish();

  const auto bytes = std::filesystem::file_size(arguments.output);
  if (arguments.json) {
    Json report = {{"dataset", json_of(info)},
                   {"input", arguments.input},
                   {"file", arguments.output},
                   {"file_bytes", bytes},
                   {"seconds", progress.seconds()}};
    std::cout << text_of(report);
  } else if (!arguments.quiet) {
    std::cout << arguments.output << ": \"" << info.name << "\", " << info.dims[0] << " x "
              << info.dims[1] << " x " << info.dims[2] << " " << name(info.type) << ", values "
              << human_number(info.min) << " to " << human_number(info.max) << ", "
              << human_bytes(bytes) << "\n"
              << "Next: multitetra-server serve " << arguments.output << "\n";
  }
  return 0;
}

}  // namespace

void add_prepare_command(Command& program, Run& run) {
  const auto a = std::make_shared<PrepareArguments>();
  Command* command =
      program.add_subcommand("prepare", "Turn a volume file into a dataset that can be served");
  command
      ->add_option(
          "input", a->input,
          "Volume: a file, a folder (DICOM, OME-Zarr, TIFF slices), a pattern of slices, or "
          "raw samples with --dims; `multitetra-server formats` lists what is read")
      ->required()
      ->type_name("SOURCE");
  command->add_option("-o,--output", a->output, "Dataset file to write (.mtd)")
      ->required()
      ->type_name("FILE");
  command->add_option("--name", a->name,
                      "Name of the dataset (default: the input's name without its suffix)");
  command
      ->add_option("--outside", a->outside,
                   "What lies beyond the data: void (surfaces end at the last sample) or a value "
                   "(they close)")
      ->capture_default_str();
  command
      ->add_option("--margin", a->margin,
                   "Grid steps around the data; 1 with a value closes surfaces on all sides")
      ->within(0, 4096)
      ->capture_default_str();
  a->volume.add_to(*command);
  command
      ->add_option("--bins", a->bins,
                   "Bins of isovalues that errors are stored for; more bins, a larger file")
      ->within(1, IsovalueBins::kMaxCount)
      ->capture_default_str();
  command->add_flag("--force", a->force,
                    "Write to a name without .mtd, too, and over a file that is no dataset");
  add_threads_option(*command, a->threads);
  command->add_flag("--json", a->json, "Print a JSON report");
  command->add_flag("--quiet", a->quiet, "Say nothing unless something is wrong");
  command->footer(
      "Examples:\n"
      "  multitetra-server prepare CThead.nhdr -o head.mtd --name head\n"
      "  multitetra-server prepare engine.mhd -o engine.mtd --outside 0 --margin 1\n"
      "  multitetra-server prepare fuel.raw --dims 64,64,64 --type u8 -o fuel.mtd\n"
      "  multitetra-server prepare 'slices/ct_*.tif' -o ct.mtd\n"
      "  multitetra-server prepare dicom_folder -o scan.mtd --series 2\n"
      "  multitetra-server prepare image.zarr -o cells.mtd --channel 1 --time 0\n"
      "  multitetra-server prepare run.h5:/fields/density -o density.mtd");
  command->callback([a, &run] { run = [a] { return prepare(*a); }; });
}

}  // namespace multitetra
