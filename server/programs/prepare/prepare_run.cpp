#include "server/programs/prepare/prepare_run.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <iostream>
#include <map>
#include <stdexcept>
#include <utility>

#include <nlohmann/json.hpp>

#include "common/base/address_text.hpp"
#include "common/base/exit_codes.hpp"
#include "common/base/utf8.hpp"
#include "common/cli/human_units.hpp"
#include "common/cli/json_report.hpp"
#include "common/cli/output_files.hpp"
#include "server/dataset/prepare.hpp"
#include "server/dataset/prepared_file.hpp"
#include "server/dataset/source_note.hpp"
#include "server/programs/prepare/dataset_output.hpp"
#include "server/programs/progress.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra {
namespace {

// What a job is called in lines for people.
std::string shown_name(const PrepareJob& job) {
  return printable(without_password(job.member ? job.name : job.input), /*keeps_lines=*/false);
}

// Throws when the output is what the input is, or cannot be written.
void require_free_output(const PrepareJob& job) {
  if (is_address(job.output.string())) return;
  require_outputs({{"--output", job.output}}, {{"input", job.input}});
}

// A label that a map does not have, which is no failure where it may come and go with time.
class MissingLabel : public VolumeFileError {
 public:
  using VolumeFileError::VolumeFileError;
};

[[noreturn]] void fail_without_label(const PrepareJob& job, const LabelMap& map) {
  const Label& missing = *job.member->label;
  if (job.stored_label != missing.value) {
    throw MissingLabel("Cannot read '" + job.input + "': segment " + label_text(missing) + " (" +
                       missing.name + ") is empty.");
  }
  std::string there;
  for (const FoundLabel& label : map.labels()) {
    if (there.size() > 60) {
      there += ", ...";
      break;
    }
    there += (there.empty() ? "" : ", ") + label_text({.value = label.value});
  }
  throw MissingLabel(
      "Cannot read '" + job.input + "': label " + label_text(missing) + " does not occur in it. " +
      (there.empty() ? "All of its samples are 0" : "Its labels are " + there) + ".");
}

std::unique_ptr<VolumeSource> open_job(const PrepareJob& job, const VolumeFileOptions& options,
                                       LatestLabelMap& maps) {
  if (!job.member || !job.member->label) return open_volume(job.input, options);
  const double value = job.stored_label;
  const LabelMap map = maps.of(job.input, options);
  const bool is_there =
      value == 0 || std::any_of(map.labels().begin(), map.labels().end(),
                                [&](const FoundLabel& label) { return label.value == value; });
  if (!is_there) fail_without_label(job, map);
  return map.field(value);
}

// Of members of a series, which lie on the same places.
struct Places {
  std::array<std::int32_t, 3> dims{};
  Affine index_to_world;
  PhysicalMeaning meaning;
};

// What the table tells of a member that lies elsewhere than the first.
void require_same_places(const PrepareJob& job, const Places& found, const Places& first,
                         const std::string& first_input) {
  const auto size = [](const Places& places) {
    return std::to_string(places.dims[0]) + " x " + std::to_string(places.dims[1]) + " x " +
           std::to_string(places.dims[2]);
  };
  const auto refuse = [&](const std::string& difference) {
    fail_reading(job.input, difference + "; members of a series lie on the same places",
                 "Resample it, or prepare it for itself");
  };
  if (found.dims != first.dims) {
    refuse("it has " + size(found) + " samples and '" + first_input + "' has " + size(first));
  }
  if (found.index_to_world != first.index_to_world || found.meaning.space != first.meaning.space ||
      found.meaning.length_unit != first.meaning.length_unit) {
    refuse("its samples lie at other places in the world than those of '" + first_input + "'");
  }
}

// Few values in an integer volume are mostly labels.
bool looks_like_labels(const DatasetInfo& info) {
  constexpr std::ptrdiff_t kFewValues = 32;
  if (info.type == SampleType::kF32 || info.member) return false;
  const auto& counts = info.histogram.counts;
  const auto values =
      std::count_if(counts.begin(), counts.end(), [](std::uint64_t count) { return count > 0; });
  return values >= 2 && values <= kFewValues;
}

struct Prepared {
  DatasetInfo info;
  std::uint64_t file_bytes = 0;
  Json seconds;
};

// Prepares jobs one by one. Those of one series must lie on the same places.
class Preparation {
 public:
  Preparation(const PrepareArguments& arguments, LatestLabelMap& maps)
      : arguments_(arguments), maps_(maps) {}

  // Throws what is wrong with the job.
  Prepared prepare_one(const PrepareJob& job, const SourceNote& note, DatasetOutput& output) {
    const std::optional<double> outside = arguments_.outside_value();
    Progress progress(job.member ? "prepare " + job.name : "prepare", 3,
                      arguments_.quiet || arguments_.json);
    progress.begin("open");
    VolumeFileOptions options = arguments_.volume.parsed();
    options.choice = job.choice;
    options.notice = [&](const std::string& text) { progress.note(text); };
    const auto source = open_job(job, options, maps_);
    const VolumeHeader& header = source->header();
    see(job, {header.dims, header.index_to_world, header.meaning});
    std::string pass;
    PrepareOptions how{.name = job.name,
                       .outside = outside,
                       .margin = arguments_.margin_steps(),
                       .bins = arguments_.bins,
                       .member = job.member};
    if (job.member && job.member->label) {
      how.suggested_isovalues = {kLabelBoundary};
      how.bin_edges = {kLabelBinEdges.begin(), kLabelBinEdges.end()};
    }
    how.progress = [&](const char* name, std::uint64_t done, std::uint64_t all) {
      if (pass != name) progress.begin(pass = name);
      progress.update(static_cast<double>(done), static_cast<double>(all), "voxels");
    };
    Prepared prepared;
    prepared.info = prepare(*source, how, output.file(), note);
    output.finish([&](double fraction) {
      if (pass != "upload") progress.begin(pass = "upload");
      progress.update(100 * fraction, 100, "%");
    });
    progress.finish();
    if (looks_like_labels(prepared.info)) {
      progress.note("'" + job.input +
                    "' has few different values and may be a label map: --label all prepares each "
                    "label as a smooth surface.");
    }
    prepared.file_bytes = std::filesystem::file_size(output.file());
    prepared.seconds = progress.seconds();
    return prepared;
  }

  // The note of a job's source. The bytes of a source are read once, however many jobs it has.
  SourceNote note_of(const PrepareJob& job) {
    auto [at, is_new] = notes_.try_emplace(job.input);
    if (is_new) at->second = source_note(job.input);
    SourceNote note = at->second;
    note.options = arguments_.told();
    for (const std::string& more : job.told)
      note.options += (note.options.empty() ? "" : " ") + more;
    return note;
  }

  // A job whose dataset is there already. Throws unless it lies on the same places.
  void see_prepared(const PrepareJob& job) {
    if (!job.member) return;
    const DatasetInfo info = PreparedFile(job.output.string()).info();
    see(job, {info.dims, info.index_to_world, info.meaning});
  }

 private:
  void see(const PrepareJob& job, const Places& places) {
    if (!job.member) return;
    const auto [first, is_new] = first_.try_emplace(job.member->series, places, job.input);
    if (!is_new) require_same_places(job, places, first->second.first, first->second.second);
  }

  const PrepareArguments& arguments_;
  LatestLabelMap& maps_;
  std::map<std::string, SourceNote> notes_;
  std::map<std::string, std::pair<Places, std::string>> first_;  // By series, with its input.
};

Json json_of(const PrepareJob& job, const Prepared& prepared) {
  return {{"dataset", json_of(prepared.info)},
          {"input", without_password(job.input)},
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

}  // namespace

LabelMap LatestLabelMap::of(const std::string& input, const VolumeFileOptions& options) {
  if (map_ && input_ == input && choice_ == options.choice) return *map_;
  map_.reset();
  const auto source = open_volume(input, options);
  map_.emplace(input, *source, folder_);
  input_ = input;
  choice_ = options.choice;
  return *map_;
}

int prepare_single(const PrepareArguments& arguments, const PrepareJob& job) {
  LatestLabelMap maps(scratch_folder(job.output.parent_path()));
  Preparation preparation(arguments, maps);
  require_free_output(job);
  DatasetOutput output(job.output, arguments.force);
  try {
    const Prepared prepared = preparation.prepare_one(job, preparation.note_of(job), output);
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

int prepare_all(const PrepareArguments& arguments, const std::vector<PrepareJob>& jobs,
                LatestLabelMap& maps) {
  Preparation preparation(arguments, maps);
  Json reports = Json::array();
  std::string table;
  std::string failures;
  std::size_t failed = 0;
  for (const PrepareJob& job : jobs) {
    const auto tell = [&](const std::string& outcome) {
      table += shown_name(job) + ": " + outcome + "\n";
    };
    try {
      require_free_output(job);
      DatasetOutput output(job.output, arguments.force);
      const SourceNote note = preparation.note_of(job);
      if (!arguments.force && is_up_to_date(job, note)) {
        preparation.see_prepared(job);
        tell("up to date");
        reports.push_back({{"input", without_password(job.input)},
                           {"file", job.output.string()},
                           {"up_to_date", true}});
        continue;
      }
      const Prepared prepared = preparation.prepare_one(job, note, output);
      tell(facts_of(prepared) + ", " + human_seconds(prepared.seconds.at("total").get<double>()));
      reports.push_back(json_of(job, prepared));
    } catch (const MissingLabel& missing) {
      const bool comes_and_goes = job.member && job.member->time;
      failed += comes_and_goes ? 0 : 1;
      tell((comes_and_goes ? "left out: " : "FAILED: ") + std::string(missing.what()));
      if (!comes_and_goes) failures += job.name + ": FAILED: " + missing.what() + "\n";
      reports.push_back({{"input", without_password(job.input)},
                         {comes_and_goes ? "left_out" : "error", missing.what()}});
    } catch (const std::exception& problem) {
      ++failed;
      tell(std::string("FAILED: ") + problem.what());
      failures += shown_name(job) + ": FAILED: " + problem.what() + "\n";
      reports.push_back({{"input", without_password(job.input)}, {"error", problem.what()}});
    }
  }
  if (arguments.json) {
    std::cout << text_of({{"volumes", reports}, {"failed", failed}});
  } else if (arguments.quiet) {
    std::cerr << failures;
  } else {
    const std::string what = arguments.series.are_given() ? " member" : " volume";
    std::cout << table << jobs.size() << what << (jobs.size() == 1 ? ", " : "s, ") << failed
              << " failed.\n";
    if (failed < jobs.size()) {
      std::cout << "Next: multitetra-server serve " << arguments.output << "\n";
    }
  }
  return failed == 0 ? kOk : kFailed;
}

}  // namespace multitetra
