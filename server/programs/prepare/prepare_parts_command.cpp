#include "server/programs/prepare/prepare_parts_command.hpp"

#include <iostream>
#include <utility>

#include "common/base/exit_codes.hpp"
#include "common/base/json.hpp"
#include "common/base/parse_number.hpp"
#include "common/cli/human_units.hpp"
#include "common/json/json_report.hpp"
#include "server/dataset/partitioned/part_plan.hpp"
#include "server/dataset/partitioned/prepare_parts.hpp"
#include "server/programs/progress.hpp"

namespace multitetra {
namespace {

// Quotes a word for the shell.
std::string quoted(const std::string& word) {
  constexpr const char* kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:-";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

PartOptions with_progress(Progress& progress, std::string& pass) {
  return {.progress = [&progress, &pass](const char* name, std::uint64_t done, std::uint64_t all) {
    if (pass != name) progress.begin(pass = name);
    progress.update(static_cast<double>(done), static_cast<double>(all), "steps");
  }};
}

std::string costs_text(const PartCosts& costs) {
  if (costs.samples == 0) return "nothing to do";
  return human_count(costs.samples) + " samples, at most " + human_bytes(costs.memory_bytes) +
         " of memory, " + human_bytes(costs.disk_bytes) + " of disk, about " +
         human_number(costs.core_seconds) + " s of one core";
}

}  // namespace

int plan_parts(VolumeSource& source, const PrepareOptions& options, Provenance note,
               const std::string& input, const std::string& output, std::size_t parts,
               const PartsReport& report) {
  VolumeSurvey found = survey(source, options);
  const PartPlan plan{.metadata = {.info = std::move(found.info),
                                   .source = std::move(note),
                                   .program_version = MULTITETRA_VERSION},
                      .bins = std::move(found.bins),
                      .parts = parts};
  write_plan(output, plan);
  const DatasetInfo& info = plan.metadata.info;
  Json lines = Json::array();
  std::size_t number = 0;
  for (const PartBox& box : part_boxes(info.dims, parts)) {
    const PartCosts costs = costs_of(info, box);
    const std::string part = std::to_string(++number) + "/" + std::to_string(parts);
    lines.push_back({{"part", part},
                     {"samples", costs.samples},
                     {"memory_bytes", costs.memory_bytes},
                     {"disk_bytes", costs.disk_bytes},
                     {"core_seconds", costs.core_seconds}});
    if (report.json) continue;
    std::cout << "multitetra-server prepare " << quoted(input) << " -o " << quoted(output)
              << " --part " << part << "  # " << costs_text(costs) << "\n";
  }
  if (report.json) std::cout << text_of({{"parts", lines}, {"dataset", json_of(info)}});
  return kOk;
}

PartNumber part_of(const std::string& text) {
  const auto numbers = parse_numbers<std::size_t>(text, 2, '/');
  if (numbers && (*numbers)[0] >= 1 && (*numbers)[0] <= (*numbers)[1] &&
      (*numbers)[1] <= kMaxParts) {
    return {.index = (*numbers)[0] - 1, .parts = (*numbers)[1]};
  }
  throw ExitError(kUsage, "--part: \"" + text +
                              "\" is not a part; write for example 3/8, of at most " +
                              std::to_string(kMaxParts) + " parts.");
}

int make_part(VolumeSource& source, const std::string& output, const std::string& part,
              const PartsReport& report) {
  const auto [number, parts] = part_of(part);
  const std::size_t planned = plan_of(output).plan.parts;
  if (parts != planned) {
    throw ExitError(kUsage, "--part: \"" + part +
                                "\" is not a part of the plan, which has parts 1/" +
                                std::to_string(planned) + " to " + std::to_string(planned) + "/" +
                                std::to_string(planned) + ".");
  }
  Progress progress("part " + part, 4, report.quiet || report.json);
  std::string pass;
  prepare_part(source, output, number, with_progress(progress, pass));
  progress.finish();
  if (report.json) {
    std::cout << text_of({{"part", part}, {"seconds", progress.seconds()}});
  } else if (!report.quiet) {
    std::cout << output << ": part " << part << "\n";
  }
  return kOk;
}

int merge(const std::string& output, const PartsReport& report) {
  Progress progress("merge", 2, report.quiet || report.json);
  std::string pass;
  const MergedDataset merged = merge_parts(output, with_progress(progress, pass));
  progress.finish();
  if (report.json) {
    std::cout << text_of({{"output", output},
                          {"dataset", json_of(merged.info)},
                          {"file_bytes", merged.file_bytes},
                          {"seconds", progress.seconds()}});
  } else if (!report.quiet) {
    std::cout << output << ": \"" << merged.info.name << "\", " << human_bytes(merged.file_bytes)
              << "\n"
              << "Next: multitetra-server serve " << output << "\n";
  }
  return kOk;
}

}  // namespace multitetra
