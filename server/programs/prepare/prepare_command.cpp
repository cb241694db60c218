#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "common/base/text.hpp"
#include "server/dataset/dataset.hpp"
#include "server/dataset/partitioned/part_plan.hpp"
#include "server/dataset/prepare.hpp"
#include "server/dataset/prepared_file.hpp"
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
    throw ExitError(kUsage, "--plan, --part and --merge exclude each other; give one of them.");
  }
  (void)DatasetOutput(arguments.output, arguments.force);
  if (arguments.inputs.size() != (parts.merge ? 0U : 1U)) {
    throw ExitError(kUsage, "--plan and --part require one volume, --merge none; " +
                                std::to_string(arguments.inputs.size()) + " are given.");
  }
  if (parts.merge) return merge(arguments.output, report);
  const std::string& input = arguments.inputs.front();
  VolumeFileOptions options = arguments.volume.parsed();
  options.notice = [&](const std::string& text) {
    if (!arguments.quiet) std::cerr << text << "\n";
  };
  const auto source = open_volume(input, options);
  if (!parts.part.empty()) return make_part(*source, arguments.output, parts.part, report);
  Provenance note = provenance(input);
  note.options = arguments.command_line();
  return plan_parts(*source,
                    {.name = arguments.name.empty() ? default_dataset_name(input) : arguments.name,
                     .outside = arguments.outside_value(),
                     .margin = arguments.margin_steps(),
                     .bins = arguments.bins},
                    std::move(note), input, arguments.output, static_cast<std::size_t>(parts.plan),
                    report);
}

// Keeps the jobs of a part, such as "3/8": every eighth, from the third on.
void keep_part(const std::string& part, std::vector<PrepareJob>& jobs) {
  const auto [index, parts] = part_of(part);
  std::vector<PrepareJob> kept;
  for (std::size_t i = index; i < jobs.size(); i += parts) kept.push_back(std::move(jobs[i]));
  jobs = std::move(kept);
}

// The output folder for several datasets. Removed at the end if it is new, empty and not shared.
class OutputFolder {
 public:
  OutputFolder(const std::string& output, bool is_shared)
      : path_(output),
        is_new_(!is_address(output) && std::filesystem::create_directories(path_) && !is_shared) {}
  ~OutputFolder() {
    std::error_code is_not_empty;
    if (is_new_) std::filesystem::remove(path_, is_not_empty);
  }
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

 private:
  std::filesystem::path path_;
  bool is_new_;
};

void require_one_mode(const PrepareArguments& arguments) {
  const SeriesArguments& series = arguments.series;
  const VolumeOptions& volume = arguments.volume;
  const auto refuse = [](bool both, const char* a, const char* b) {
    if (!both) return;
    throw ExitError(kUsage, std::string(a) + " and " + b + " exclude each other.");
  };
  if (arguments.makes_several() && (arguments.parts.plan > 0 || arguments.parts.merge)) {
    throw ExitError(
        kUsage,
        "Several datasets need no plan: prepare a share of them with each of --part 1/8 "
        "to 8/8, and at the end the same without --part, for what is missing.");
  }
  refuse(arguments.samples_only && arguments.parts.are_given(), "--samples-only",
         "--plan, --part, --merge");
  refuse(series.all_times && volume.time.has_value(), "--all-times", "--time");
  refuse(!series.fields.empty() && !volume.array.empty(), "--field", "--array");
  refuse(!series.fields.empty() && volume.channel.has_value(), "--field", "--channel");
  refuse(!series.time_series.empty() && !arguments.name.empty(), "--time-series", "--name");
}

// Prepares one dataset into a file, or several into a folder.
int prepare_volumes(const PrepareArguments& arguments) {
  const std::filesystem::path output = arguments.output;
  const bool is_part = arguments.parts.are_given();
  const bool is_file = !is_folder_of_datasets(arguments.output) &&
                       (!arguments.makes_several() || output.extension() == ".mtd");
  std::optional<OutputFolder> folder;
  if (!is_file) folder.emplace(arguments.output, is_part);
  LatestLabelMap maps(scratch_folder(is_file ? output.parent_path() : output),
                      arguments.label_ends());
  std::vector<PrepareJob> jobs = jobs_of(arguments, maps, [&](const std::string& text) {
    if (!arguments.quiet) std::cerr << "prepare: " << text << "\n";
  });
  if (is_part) keep_part(arguments.parts.part, jobs);
  if (!is_file) return prepare_all(arguments, jobs, maps);
  if (jobs.size() != 1) {
    throw ExitError(kUsage, "--output: " + arguments.output + " is the name of one dataset, but " +
                                std::to_string(jobs.size()) +
                                " are to be prepared; give a folder.");
  }
  jobs.front().output = output;
  return prepare_single(arguments, jobs.front(), maps);
}

bool are_datasets(const PrepareArguments& arguments) {
  return !arguments.inputs.empty() && !arguments.parts.are_given() &&
         std::all_of(arguments.inputs.begin(), arguments.inputs.end(), is_dataset_file);
}

// Computes the errors that datasets lack, in place or into the output.
int complete_datasets(PrepareArguments& arguments) {
  if (arguments.samples_only) {
    throw ExitError(kUsage,
                    "--samples-only: " + arguments.inputs.front() + " has its samples already.");
  }
  if (arguments.output.empty()) arguments.output = arguments.inputs.front();
  const std::filesystem::path output = arguments.output;
  const bool is_folder = is_folder_of_datasets(arguments.output);
  const bool is_in_place = arguments.output == arguments.inputs.front();
  if (!is_folder && !is_in_place && arguments.inputs.size() > 1) {
    throw ExitError(kUsage, "--output: give a folder for several datasets.");
  }
  std::vector<PrepareJob> jobs;
  for (const std::string& input : arguments.inputs) {
    if (!is_in_place && PreparedFile(input).info().missing.empty()) {
      throw ExitError(kUsage,
                      "'" + input + "': it is already a prepared dataset, with its errors.");
    }
    const std::filesystem::path name = std::filesystem::path(input).filename();
    jobs.push_back({.input = input,
                    .output = is_in_place ? std::filesystem::path(input)
                              : is_folder ? output / name
                                          : output,
                    .name = input});
  }
  LatestLabelMap unused({}, LabelEnds::kOpen);
  return prepare_all(arguments, jobs, unused);
}

// Splits a list of components, such as "0,1,magnitude"; each is a field of a series.
void split_components(PrepareArguments& arguments) {
  std::string& component = arguments.volume.component;
  if (component.find(',') == std::string::npos) return;
  for (const std::string_view part : split(component, ',')) {
    arguments.series.components.emplace_back(part);
  }
  component.clear();
}

int prepare(PrepareArguments& arguments) {
  const ThreadLimit limit(arguments.threads);
  split_components(arguments);
  arguments.series.check();
  require_one_mode(arguments);
  (void)arguments.volume.parsed();
  (void)arguments.outside_value();
  try {
    if (arguments.parts.are_given() && !arguments.makes_several()) {
      return prepare_in_parts(arguments);
    }
    if (arguments.inputs.empty()) throw ExitError(kUsage, "Give a volume to prepare.");
    if (are_datasets(arguments)) return complete_datasets(arguments);
    return prepare_volumes(arguments);
  } catch (const VolumeFileError& problem) {
    throw ExitError(kUsage, problem.what());
  }
}

constexpr const char* kPrepareExamples =
    "Examples:\n"
    "  multitetra-server prepare CThead.nhdr -o head.mtd --name head\n"
    "  multitetra-server prepare engine.mhd -o engine.mtd --pad-value 0 --pad 1\n"
    "  multitetra-server prepare fuel.raw --dims 64,64,64 --type u8 -o fuel.mtd\n"
    "  multitetra-server prepare 'slices/ct_*.tif' -o ct.mtd\n"
    "  multitetra-server prepare scans/ -o datasets/\n"
    "  multitetra-server prepare dicom_folder -o scan.mtd --series 2\n"
    "  multitetra-server prepare image.zarr -o cells.mtd --channel 1 --time 0\n"
    "  multitetra-server prepare run.h5:/fields/density -o density.mtd\n"
    "Series, datasets on the same grid:\n"
    "  multitetra-server prepare seg.nii.gz --label all -o organs/\n"
    "  multitetra-server prepare heart4d.nii.gz --all-times -o heart/\n"
    "  multitetra-server prepare flow_*.vti --time-series flow --times 0:0.1 --time-unit s -o "
    "flow/\n"
    "  multitetra-server prepare run.vti --field pressure,temperature -o run/\n"
    "On several machines, in a shared folder or a bucket, or copying big.mtd.parts together:\n"
    "  multitetra-server prepare big.nrrd -o big.mtd --plan 8 | xargs -P 8 -d '\\n"
    "' -n 1 sh -c\n"
    "  multitetra-server prepare --merge -o big.mtd\n"
    "  seq 8 | xargs -P 8 -I{} multitetra-server prepare heart4d.nii.gz --all-times -o heart/ "
    "--part {}/8";

void add_parts_options(Command& command, PartsArguments& parts) {
  command.begin_group("On several machines");
  command
      .add_option("--plan", parts.plan,
                  "Plan the preparation in this many parts on several machines: reads the volume "
                  "once and prints a command for each part")
      ->within(1, static_cast<int>(kMaxParts));
  command.add_option("--part", parts.part,
                     "Prepare this part of the plan, for example 3/8; of several datasets, such as "
                     "times, every eighth, without a plan");
  command.add_flag("--merge", parts.merge, "Create the dataset from all parts of the plan");
}

}  // namespace

void add_prepare_command(Command& program, Run& run) {
  const auto a = std::make_shared<PrepareArguments>();
  Command* command =
      program.add_subcommand("prepare", "Convert a volume file into a dataset that can be served");
  command
      ->add_option("input", a->inputs,
                   "Volumes: a file, a folder (DICOM, OME-Zarr, TIFF slices), a pattern of slices, "
                   "raw samples with --dims, or the address of an OME-Zarr; several of them, or a "
                   "folder of many. `multitetra-server formats` lists the formats. Datasets (.mtd) "
                   "without errors are completed")
      ->type_name("SOURCE");
  command
      ->add_option("-o,--output", a->output,
                   "Dataset file to write (.mtd), or a folder for several; also in a bucket "
                   "(s3://bucket/head.mtd)")
      ->type_name("FILE");
  command->add_option("--name", a->name,
                      "Name of the dataset; default: the input's name without its suffix");
  add_threads_option(*command, a->threads);
  command->add_flag("--json", a->json, "Print a JSON report");
  command->add_flag("--quiet", a->quiet, "Print errors and notices about the data only");
  add_border_options(*command, a->outside, a->margin);
  a->series.add_to(*command);
  command->begin_group("Reading the volume");
  a->volume.add_to(*command);
  a->volume.add_space_to(*command);
  command->begin_group("Grid and errors");
  command
      ->add_option("--bins", a->bins,
                   "Number of isovalue bins with stored errors; more bins make a larger file")
      ->within(1, IsovalueBins::kMaxCount)
      ->capture_default_str();
  command->add_flag("--samples-only", a->samples_only,
                    "Leave out the errors, for a dataset to serve at once; `prepare FILE.mtd` adds "
                    "them");
  add_parts_options(*command, a->parts);
  command->begin_group("Output");
  command->add_flag("--force", a->force,
                    "Also write to names without .mtd, replace files that are not datasets and "
                    "datasets of other sources, and prepare up-to-date datasets again");
  command->footer(kPrepareExamples);
  command->callback([a, &run] {
    if (a->output.empty() && !are_datasets(*a)) {
      throw UsageError("output", "give the dataset to write.");
    }
    run = [a] { return prepare(*a); };
  });
}

}  // namespace multitetra
