#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "server/dataset/dataset.hpp"
#include "server/dataset/partitioned/part_plan.hpp"
#include "server/dataset/prepare.hpp"
#include "server/dataset/provenance.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/prepare/dataset_output.hpp"
#include "server/programs/prepare/prepare_jobs.hpp"
#include "server/programs/prepare/prepare_parts_command.hpp"
#include "server/programs/prepare/prepare_run.hpp"
#include "server/programs/prepare/series_jobs.hpp"
#include "server/programs/thread_options.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra {
namespace {

// Runs --plan, --part or --merge.
int prepare_in_parts(const PrepareArguments& arguments) {
  const PartsReport report{.json = arguments.json, .quiet = arguments.quiet};
  const PartsArguments& parts = arguments.parts;
  if ((parts.plan > 0) + !parts.part.empty() + parts.merge != 1) {
    throw ExitError(kUsage, "--plan, --part and --merge are three commands; give one of them.");
  }
  if (is_address(arguments.output)) {
    throw ExitError(kUsage, "--output: parts become a file on this machine, not " +
                                arguments.output + "; copy it when it is there.");
  }
  (void)DatasetOutput(arguments.output, arguments.force);
  if (arguments.inputs.size() != (parts.merge ? 0U : 1U)) {
    throw ExitError(kUsage, "--plan and --part take one volume, --merge takes none; " +
                                std::to_string(arguments.inputs.size()) + " are given.");
  }
  if (parts.merge) return merge(arguments.output, report);
  const std::string& input = arguments.inputs.front();
  try {
    VolumeFileOptions options = arguments.volume.parsed();
    options.notice = [&](const std::string& text) {
      if (!arguments.quiet) std::cerr << text << "\n";
    };
    const auto source = open_volume(input, options);
    if (!parts.part.empty()) return make_part(*source, arguments.output, parts.part, report);
    Provenance note = provenance(input);
    note.options = arguments.command_line();
    return plan_parts(
        *source,
        {.name = arguments.name.empty() ? default_dataset_name(input) : arguments.name,
         .outside = arguments.outside_value(),
         .margin = arguments.margin_steps(),
         .bins = arguments.bins},
        std::move(note), input, arguments.output, static_cast<std::size_t>(parts.plan), report);
  } catch (const VolumeFileError& problem) {
    throw ExitError(kUsage, problem.what());
  }
}

// The output folder for several volumes or members of series. Removed at the end if it is new and
// empty.
class OutputFolder {
 public:
  explicit OutputFolder(const std::string& output) : path_(output) {
    if (path_.extension() == ".mtd") {
      throw ExitError(kUsage, "--output: " + output +
                                  " is a name for one dataset, and there are several volumes; give "
                                  "a folder.");
    }
    is_new_ = !is_address(output) && std::filesystem::create_directories(path_);
  }
  ~OutputFolder() {
    std::error_code is_not_empty;
    if (is_new_) std::filesystem::remove(path_, is_not_empty);
  }
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

 private:
  std::filesystem::path path_;
  bool is_new_ = false;
};

int prepare_many(const PrepareArguments& arguments) {
  if (!arguments.name.empty()) {
    throw ExitError(kUsage, "--name is for one volume; several are named after their files.");
  }
  std::vector<PrepareJob> jobs = jobs_for(arguments.inputs, arguments.output);
  if (jobs.empty()) {
    const std::string& input = arguments.inputs.front();
    const bool holds_datasets = is_folder_of_datasets(input) && !datasets_in(input).empty();
    throw ExitError(
        kUsage, "There is no volume in " + input +
                    (holds_datasets ? ", but datasets: multitetra-server serve " + input : "."));
  }
  const OutputFolder folder(arguments.output);
  for (PrepareJob& job : jobs) job.choice = arguments.volume.parsed().choice;
  LatestLabelMap maps(scratch_folder(arguments.output));
  return prepare_all(arguments, jobs, maps);
}

int prepare_one_volume(const PrepareArguments& arguments) {
  PrepareJob job{.input = arguments.inputs.front(),
                 .output = arguments.output,
                 .name = arguments.name,
                 .choice = arguments.volume.parsed().choice};
  if (job.name.empty()) job.name = default_dataset_name(job.input);
  return prepare_single(arguments, job);
}

void require_one_mode(const PrepareArguments& arguments) {
  const SeriesArguments& series = arguments.series;
  const VolumeOptions& volume = arguments.volume;
  const auto refuse = [](bool both, const char* a, const char* b) {
    if (!both) return;
    throw ExitError(kUsage, std::string(a) + " and " + b + " exclude each other.");
  };
  refuse(arguments.parts.are_given(), "Series (--label, --all-times, --field, --time-series)",
         "--plan, --part, --merge");
  refuse(series.all_times && volume.time.has_value(), "--all-times", "--time");
  refuse(!series.fields.empty() && !volume.array.empty(), "--field", "--array");
  refuse(!series.fields.empty() && volume.channel.has_value(), "--field", "--channel");
  refuse(!series.time_series.empty() && !arguments.name.empty(), "--time-series", "--name");
}

int prepare_series(const PrepareArguments& arguments) {
  require_one_mode(arguments);
  const std::filesystem::path output = arguments.output;
  const bool is_file = output.extension() == ".mtd";  // A single label or field needs no folder.
  std::optional<OutputFolder> folder;
  if (!is_file) folder.emplace(arguments.output);
  const auto notice = [&](const std::string& text) {
    if (!arguments.quiet) std::cerr << "prepare: " << text << "\n";
  };
  LatestLabelMap maps(scratch_folder(is_file ? output.parent_path() : output));
  try {
    std::vector<PrepareJob> jobs = series_jobs(arguments, maps, notice);
    if (!is_file) return prepare_all(arguments, jobs, maps);
    if (jobs.size() != 1) {
      throw ExitError(kUsage, "--output: " + arguments.output + " is a name for one dataset, and " +
                                  std::to_string(jobs.size()) + " are to be made; give a folder.");
    }
    jobs.front().output = output;
    return prepare_single(arguments, jobs.front());
  } catch (const VolumeFileError& problem) {
    throw ExitError(kUsage, problem.what());
  }
}

// Splits a list of components, such as "0,1,magnitude"; each is a field of a series.
void split_components(PrepareArguments& arguments) {
  std::string& component = arguments.volume.component;
  if (component.find(',') == std::string::npos) return;
  for (std::size_t begin = 0; begin <= component.size();) {
    const std::size_t end = std::min(component.find(',', begin), component.size());
    arguments.series.components.push_back(component.substr(begin, end - begin));
    begin = end + 1;
  }
  component.clear();
}

int prepare(PrepareArguments& arguments) {
  const ThreadLimit limit(arguments.threads);
  split_components(arguments);
  arguments.series.check();
  if (arguments.series.are_given() && arguments.parts.are_given()) require_one_mode(arguments);
  if (arguments.parts.are_given()) return prepare_in_parts(arguments);
  if (arguments.inputs.empty()) throw ExitError(kUsage, "Name a volume to prepare.");
  (void)arguments.volume.parsed();
  (void)arguments.outside_value();
  if (arguments.series.are_given()) return prepare_series(arguments);
  const bool into_folder = is_folder_of_datasets(arguments.output);
  return into_folder || has_several_volumes(arguments.inputs) ? prepare_many(arguments)
                                                              : prepare_one_volume(arguments);
}

}  // namespace

void add_prepare_command(Command& program, Run& run) {
  const auto a = std::make_shared<PrepareArguments>();
  Command* command =
      program.add_subcommand("prepare", "Turn a volume file into a dataset that can be served");
  command
      ->add_option(
          "input", a->inputs,
          "Volumes: a file, a folder (DICOM, OME-Zarr, TIFF slices), a pattern of slices, or "
          "raw samples with --dims, an address of an OME-Zarr; several of them, or a folder of "
          "many. "
          "`multitetra-server formats` lists what is read")
      ->type_name("SOURCE");
  command
      ->add_option("-o,--output", a->output,
                   "Dataset file to write (.mtd), or a folder for several; may be in a bucket "
                   "(s3://bucket/head.mtd)")
      ->required()
      ->type_name("FILE");
  command->add_option("--name", a->name,
                      "Name of the dataset; default: the input's name without its suffix");
  add_threads_option(*command, a->threads);
  command->add_flag("--json", a->json, "Print a JSON report");
  command->add_flag("--quiet", a->quiet, "Print errors only");
  add_border_options(*command, a->outside, a->margin);
  a->series.add_to(*command);
  command->begin_group("Reading the volume");
  a->volume.add_to(*command);
  a->volume.add_space_to(*command);
  command->begin_group("Grid and errors");
  command
      ->add_option("--bins", a->bins,
                   "Bins of isovalues that errors are stored for; more bins, a larger file")
      ->within(1, IsovalueBins::kMaxCount)
      ->capture_default_str();
  command->begin_group("On several machines");
  command
      ->add_option("--plan", a->parts.plan,
                   "Plan the preparation in this many parts on several machines: reads the volume "
                   "once and prints a command for each part")
      ->within(1, static_cast<int>(kMaxParts));
  command->add_option("--part", a->parts.part, "Prepare this part of the plan, for example 3/8");
  command->add_flag("--merge", a->parts.merge, "Make the dataset from all parts of the plan");
  command->begin_group("Output");
  command->add_flag("--force", a->force,
                    "Also write to names without .mtd, replace files that are no datasets and "
                    "datasets of other sources, and prepare again what is up to date");
  command->footer(
      "Examples:\n"
      "  multitetra-server prepare CThead.nhdr -o head.mtd --name head\n"
      "  multitetra-server prepare engine.mhd -o engine.mtd --outside 0 --margin 1\n"
      "  multitetra-server prepare fuel.raw --dims 64,64,64 --type u8 -o fuel.mtd\n"
      "  multitetra-server prepare 'slices/ct_*.tif' -o ct.mtd\n"
      "  multitetra-server prepare scans/ -o datasets/\n"
      "  multitetra-server prepare dicom_folder -o scan.mtd --series 2\n"
      "  multitetra-server prepare image.zarr -o cells.mtd --channel 1 --time 0\n"
      "  multitetra-server prepare run.h5:/fields/density -o density.mtd\n"
      "Series, datasets on the same places:\n"
      "  multitetra-server prepare seg.nii.gz --label all -o organs/\n"
      "  multitetra-server prepare heart4d.nii.gz --all-times -o heart/\n"
      "  multitetra-server prepare flow_*.vti --time-series flow --times 0:0.1 --time-unit s -o "
      "flow/\n"
      "  multitetra-server prepare run.vti --field pressure,temperature -o run/\n"
      "On several machines, in a folder that all of them see, or copying big.mtd.parts together:\n"
      "  multitetra-server prepare big.nrrd -o big.mtd --plan 8 | xargs -P 8 -d '\\n' -n 1 sh -c\n"
      "  multitetra-server prepare --merge -o big.mtd");
  command->callback([a, &run] { run = [a] { return prepare(*a); }; });
}

}  // namespace multitetra
