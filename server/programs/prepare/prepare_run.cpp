#include "server/programs/prepare/prepare_run.hpp"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "common/base/address_text.hpp"
#include "common/base/exit_codes.hpp"
#include "common/base/json.hpp"
#include "common/base/number_text.hpp"
#include "common/base/utf8.hpp"
#include "common/cli/human_units.hpp"
#include "common/json/json_report.hpp"
#include "server/dataset/label_detection.hpp"
#include "server/dataset/prepared_file.hpp"
#include "server/dataset/section_table.hpp"
#include "server/programs/label_volume_text.hpp"
#include "server/programs/prepare/prepare_arguments.hpp"
#include "server/programs/prepare/prepare_jobs.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// Returns whether the jobs, or options such as --label all, cover the member's place in its series.
bool is_requested(const SeriesMember& member, const SeriesArguments& requested,
                  const std::vector<PrepareJob>& jobs) {
  const bool has_times = requested.all_times || !requested.time_series.empty();
  return std::any_of(jobs.begin(), jobs.end(), [&](const PrepareJob& job) {
    return job.member && job.member->series == member.series && job.member->field == member.field &&
           job.member->label.has_value() == member.label.has_value() &&
           (requested.wants_all_labels() || job.member->label == member.label) &&
           job.member->time.has_value() == member.time.has_value() &&
           (has_times || job.member->time == member.time);
  });
}

std::optional<SeriesMember> member_in(const fs::path& dataset) {
  try {
    return PreparedFile(dataset.string()).info().member;
  } catch (const std::exception&) {  // Keep a file that is not a dataset or is damaged.
    return std::nullopt;
  }
}

// Removes members that an earlier run of the same preparation made and that the series no longer
// has: of the same series and fields, with times and labels that `arguments` select. Requires a
// local folder. Returns messages for them.
std::string remove_stale_members(const PrepareArguments& arguments,
                                 const std::vector<PrepareJob>& jobs) {
  std::set<fs::path> stale;
  std::error_code error;
  for (fs::directory_iterator at(arguments.output, error), end; !error && at != end;
       at.increment(error)) {
    const fs::path& file = at->path();
    const bool is_made = std::any_of(jobs.begin(), jobs.end(), [&](const PrepareJob& job) {
      return job.output.filename() == file.filename();
    });
    if (file.extension() != ".mtd" || is_made) continue;
    const auto member = member_in(file);
    if (member && is_requested(*member, arguments.series, jobs)) stale.insert(file);
  }
  std::string lines;
  for (const fs::path& file : stale) {
    fs::remove(file);
    lines += file.string() + ": removed; it is no longer in the series\n";
  }
  return lines;
}

// Returns a job's name for messages.
std::string shown_name(const PrepareJob& job) {
  return printable(without_password(job.member ? job.name : job.input), /*keeps_lines=*/false);
}

Json json_of(const PrepareJob& job, const PrepareResult& prepared) {
  Json json = {{"dataset", json_of(prepared.info)},
               {"input", without_password(job.input)},
               {"file", job.output.string()},
               {"file_bytes", prepared.file_bytes},
               {"seconds", prepared.seconds}};
  if (prepared.label_volume) json["label_volume"] = json_of(*prepared.label_volume);
  return json;
}

std::string facts_of(const PrepareResult& prepared) {
  const DatasetInfo& info = prepared.info;
  const std::string& unit = info.meaning.value_unit;
  return "\"" + info.name + "\", " + sides_text(info.dims) + " " + std::string(name(info.type)) +
         ", values " + human_value(info.min, info) + " to " + human_value(info.max, info) +
         (unit.empty() ? "" : " " + unit) + ", " + human_bytes(prepared.file_bytes) +
         (prepared.label_volume ? ", " + human_label_volume(*prepared.label_volume, info) : "");
}

void hint_at_labels(const PrepareArguments& arguments, const PrepareJob& job,
                    const PrepareResult& prepared) {
  if (arguments.quiet || arguments.json || is_address(job.output.string())) return;
  if (!looks_like_labels(prepared.info, *PreparedFile(job.output.string()).samples())) return;
  std::cerr << "prepare: '" << shown_name(job)
            << "' looks like a label map: --label all prepares each label as a smooth surface."
            << std::endl;
}

}  // namespace

int prepare_single(const PrepareArguments& arguments, const PrepareJob& job, LatestLabelMap& maps) {
  Preparation preparation(arguments, maps);
  require_free_output(job);
  DatasetOutput output(job.output, arguments.force);
  const PrepareResult prepared =
      preparation.prepare_one(job, preparation.provenance_of(job), output);
  hint_at_labels(arguments, job, prepared);
  if (arguments.json) {
    std::cout << text_of(json_of(job, prepared));
  } else if (!arguments.quiet) {
    std::cout << printable(job.output.string() + ": " + facts_of(prepared) + "\n" +
                           "Next: multitetra-server serve " + job.output.string() + "\n");
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
    const auto report = [&](const std::string& outcome) {
      table += shown_name(job) + ": " + outcome + "\n";
    };
    try {
      const auto prepared = preparation.prepare_unless_up_to_date(job);
      if (!prepared) {
        report("up to date");
        reports.push_back({{"input", without_password(job.input)},
                           {"file", job.output.string()},
                           {"up_to_date", true}});
        continue;
      }
      hint_at_labels(arguments, job, *prepared);
      report(facts_of(*prepared) + ", " +
             human_seconds(prepared->seconds.at("total").get<double>()));
      reports.push_back(json_of(job, *prepared));
    } catch (const MissingLabel& missing) {
      const bool is_time_member = job.member && job.member->time;
      failed += is_time_member ? 0 : 1;
      const bool has_earlier = is_time_member && begins_as_dataset(job.output);
      if (has_earlier) std::filesystem::remove(job.output);  // The dataset of a previous run.
      report((is_time_member ? "skipped: " : "FAILED: ") + std::string(missing.what()));
      if (!is_time_member) failures += job.name + ": FAILED: " + missing.what() + "\n";
      reports.push_back({{"input", without_password(job.input)},
                         {is_time_member ? "left_out" : "error", missing.what()}});
    } catch (const std::exception& problem) {
      ++failed;
      report(std::string("FAILED: ") + problem.what());
      failures += shown_name(job) + ": FAILED: " + problem.what() + "\n";
      reports.push_back({{"input", without_password(job.input)}, {"error", problem.what()}});
    }
  }
  const bool is_whole = !arguments.parts.are_given();
  if (failed == 0 && is_whole && arguments.series.are_given() && !is_address(arguments.output)) {
    table += remove_stale_members(arguments, jobs);
  }
  if (arguments.json) {
    std::cout << text_of({{"volumes", reports}, {"failed", failed}});
  } else if (arguments.quiet) {
    std::cerr << printable(failures);
  } else {
    const std::string what = arguments.series.are_given() ? " member" : " volume";
    std::cout << printable(table) << jobs.size() << what << (jobs.size() == 1 ? ", " : "s, ")
              << failed << " failed.\n";
    if (failed < jobs.size()) {
      std::cout << "Next: multitetra-server serve " << printable(arguments.output) << "\n";
    }
  }
  return failed == 0 ? kOk : kFailed;
}

}  // namespace multitetra
