#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/base/exit_codes.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/json_report.hpp"
#include "common/cli/output_files.hpp"
#include "server/dataset/parts/part_plan.hpp"
#include "server/dataset/prepare.hpp"
#include "server/dataset/section_table.hpp"
#include "server/dataset/source_note.hpp"
#include "server/dataset/volume_files.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/prepare_jobs.hpp"
#include "server/programs/prepare_parts_command.hpp"
#include "server/programs/progress.hpp"
#include "server/programs/thread_options.hpp"
#include "server/programs/volume_options.hpp"

namespace multitetra {
namespace {

struct PrepareArguments {
  std::vector<std::string> inputs;
  std::string output;
  std::string name;
  std::string outside = "void";
  std::int32_t margin = 0;
  VolumeOptions volume;
  PartsArguments parts;
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

// Throws unless the dataset may take this name: what is there may be nobody's but an older
// dataset's, and the input's in no case.
void check_output(const PrepareJob& job, bool force) {
  const std::filesystem::path& output = job.output;
  require_outputs({{"--output", output}}, {{"input", job.input}});
  if (force) return;
  if (output.extension() != ".mtd") {
    throw ExitError(kUsage, "--output: the name of a dataset ends in .mtd, and \"" +
                                output.string() + "\" does not; --force takes it all the same.");
  }
  if (std::filesystem::exists(output) && std::filesystem::file_size(output) > 0 &&
      !begins_as_dataset(output)) {
    throw ExitError(kUsage, "--output: " + output.string() +
                                " is there already and no dataset; --force replaces it.");
  }
}

// What was asked for beyond the source, as text: another text, another dataset.
std::string options_text(const PrepareArguments& arguments) {
  std::string text = arguments.volume.told();
  const auto tell = [&](const char* name, const std::string& value, const std::string& usual) {
    if (value != usual) text += std::string(text.empty() ? "" : " ") + name + " " + value;
  };
  tell("--outside", arguments.outside, "void");
  tell("--margin", std::to_string(arguments.margin), "0");
  tell("--bins", std::to_string(arguments.bins), std::to_string(IsovalueBins::kDefaultCount));
  return text;
}

struct Prepared {
  DatasetInfo info;
  std::uint64_t file_bytes = 0;
  Json seconds;
};

Prepared prepare_one(const PrepareArguments& arguments, const PrepareJob& job, SourceNote note) {
  const std::optional<double> outside = outside_value(arguments.outside);
  Progress progress("prepare", 3, arguments.quiet || arguments.json);
  progress.begin("open");
  VolumeFileOptions options = arguments.volume.parsed();
  options.notice = [&](const std::string& text) { progress.note(text); };
  const auto source = open_volume(job.input, options);
  std::string pass;
  Prepared prepared;
  prepared.info =
      prepare(*source,
              {.name = job.name,
               .outside = outside,
               .margin = arguments.margin,
               .bins = arguments.bins,
               .progress =
                   [&](const char* name, std::uint64_t done, std::uint64_t all) {
                     if (pass != name) progress.begin(pass = name);
                     progress.update(static_cast<double>(done), static_cast<double>(all), "voxels");
                   }},
              job.output, note);
  progress.finish();
  prepared.file_bytes = std::filesystem::file_size(job.output);
  prepared.seconds = progress.seconds();
  return prepared;
}

Json json_of(const PrepareJob& job, const Prepared& prepared) {
  return {{"dataset", json_of(prepared.info)},
          {"input", job.input},
          {"file", job.output.string()},
          {"file_bytes", prepared.file_bytes},
          {"seconds", prepared.seconds}};
}

std::string facts_of(const Prepared& prepared) {
  const DatasetInfo& info = prepared.info;
  const std::string& unit = info.meaning.value_unit;
  return "\"" + info.name + "\", " + std::to_string(info.dims[0]) + " x " +
         std::to_string(info.dims[1]) + " x " + std::to_string(info.dims[2]) + " " +
         std::string(name(info.type)) + ", values " + human_number(info.min) + " to " +
         human_number(info.max) + (unit.empty() ? "" : " " + unit) + ", " +
         human_bytes(prepared.file_bytes);
}

int prepare_single(const PrepareArguments& arguments) {
  PrepareJob job{
      .input = arguments.inputs.front(), .output = arguments.output, .name = arguments.name};
  if (job.name.empty()) job.name = default_dataset_name(job.input);
  check_output(job, arguments.force);
  SourceNote note = source_note(job.input);
  note.options = options_text(arguments);
  try {
    const Prepared prepared = prepare_one(arguments, job, note);
    if (arguments.json) {
      std::cout << text_of(json_of(job, prepared));
    } else if (!arguments.quiet) {
      std::cout << job.output.string() << ": " << facts_of(prepared) << "\n"
                << "Next: multitetra-server serve " << job.output.string() << "\n";
    }
  } catch (const VolumeFileError& problem) {
    throw ExitError(kUsage, problem.what());
  }
  return kOk;
}

// Goes on after a failure; what is up to date is not made again. Ends with a table.
int prepare_many(const PrepareArguments& arguments) {
  if (!arguments.name.empty()) {
    throw ExitError(kUsage, "--name is for one volume; several are named after their files.");
  }
  if (std::filesystem::path(arguments.output).extension() == ".mtd") {
    throw ExitError(kUsage, "--output: " + arguments.output +
                                " is a name for one dataset, and there are several volumes; give a "
                                "folder.");
  }
  std::filesystem::create_directories(arguments.output);
  const std::vector<PrepareJob> jobs = jobs_for(arguments.inputs, arguments.output);
  if (jobs.empty())
    throw ExitError(kUsage, "There is no volume in " + arguments.inputs.front() + ".");
  Json reports = Json::array();
  std::string table;
  std::size_t failed = 0;
  for (const PrepareJob& job : jobs) {
    const auto tell = [&](const std::string& outcome) {
      table += job.input + ": " + outcome + "\n";
    };
    try {
      check_output(job, arguments.force);
      SourceNote note = source_note(job.input);
      note.options = options_text(arguments);
      if (!arguments.force && is_up_to_date(job, note)) {
        tell("up to date");
        reports.push_back(
            {{"input", job.input}, {"file", job.output.string()}, {"up_to_date", true}});
        continue;
      }
      const Prepared prepared = prepare_one(arguments, job, note);
      tell(facts_of(prepared) + ", " + human_number(prepared.seconds.at("total").get<double>()) +
           " s");
      reports.push_back(json_of(job, prepared));
    } catch (const std::exception& problem) {
      ++failed;
      tell(std::string("FAILED: ") + problem.what());
      reports.push_back({{"input", job.input}, {"error", problem.what()}});
    }
  }
  if (arguments.json) {
    std::cout << text_of({{"volumes", reports}, {"failed", failed}});
  } else {
    std::cout << table;
    if (!arguments.quiet) {
      std::cout << jobs.size() << " volumes, " << failed << " failed.\n"
                << "Next: multitetra-server serve " << arguments.output << "\n";
    }
  }
  return failed == 0 ? kOk : kFailed;
}

// --plan, --part, --merge: into a folder of objects.
int prepare_in_parts(const PrepareArguments& arguments) {
  const PartsReport report{.json = arguments.json, .quiet = arguments.quiet};
  const PartsArguments& parts = arguments.parts;
  if ((parts.plan > 0) + !parts.part.empty() + parts.merge != 1) {
    throw ExitError(kUsage, "--plan, --part and --merge are three commands; give one of them.");
  }
  if (std::filesystem::path(arguments.output).extension() == ".mtd") {
    throw ExitError(kUsage,
                    "--output: parts become a folder of objects, whose name does not end in .mtd.");
  }
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
    SourceNote note = source_note(input);
    note.options = options_text(arguments);
    return plan_parts(
        *source,
        {.name = arguments.name.empty() ? default_dataset_name(input) : arguments.name,
         .outside = outside_value(arguments.outside),
         .margin = arguments.margin,
         .bins = arguments.bins},
        std::move(note), input, arguments.output, static_cast<std::size_t>(parts.plan), report);
  } catch (const VolumeFileError& problem) {
    throw ExitError(kUsage, problem.what());
  }
}

int prepare(const PrepareArguments& arguments) {
  const ThreadLimit limit(arguments.threads);
  if (arguments.parts.are_given()) return prepare_in_parts(arguments);
  if (arguments.inputs.empty()) throw ExitError(kUsage, "Name a volume to prepare.");
  (void)arguments.volume.parsed();
  (void)outside_value(arguments.outside);
  const bool into_folder = std::filesystem::is_directory(arguments.output);
  return into_folder || are_many(arguments.inputs) ? prepare_many(arguments)
                                                   : prepare_single(arguments);
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
                   "Dataset file to write (.mtd); for several volumes, a folder; with parts, a "
                   "folder of objects")
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
  command
      ->add_option("--plan", a->parts.plan,
                   "Plan to prepare in so many parts, on as many machines as there are: reads the "
                   "volume once and prints a command for each part")
      ->within(1, static_cast<int>(kMostParts));
  command->add_option("--part", a->parts.part, "Prepare this part of the plan, for example 3/8");
  command->add_flag("--merge", a->parts.merge, "Make the dataset from all parts of the plan");
  command->add_flag(
      "--force", a->force,
      "Write to a name without .mtd, too, over a file that is no dataset, and what is up "
      "to date");
  add_threads_option(*command, a->threads);
  command->add_flag("--json", a->json, "Print a JSON report");
  command->add_flag("--quiet", a->quiet, "Say nothing unless something is wrong");
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
      "On several machines, into a folder that all of them see:\n"
      "  multitetra-server prepare big.nrrd -o big --plan 8 | xargs -P 8 -d '\\n' -n 1 sh -c\n"
      "  multitetra-server prepare --merge -o big");
  command->callback([a, &run] { run = [a] { return prepare(*a); }; });
}

}  // namespace multitetra
