#include "server/programs/prepare/detail/preparation.hpp"

#include <algorithm>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "common/base/address_text.hpp"
#include "common/base/exit_codes.hpp"
#include "common/base/in_parallel.hpp"
#include "common/base/json.hpp"
#include "common/base/number_text.hpp"
#include "common/cli/output_files.hpp"
#include "server/dataset/prepare.hpp"
#include "server/dataset/prepared_file.hpp"
#include "server/programs/progress.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra {
namespace {

[[noreturn]] void fail_without_label(const PrepareJob& job, const LabelMap& map) {
  const Label& missing = *job.member->label;
  if (job.stored_label != missing.value) {
    throw MissingLabel("Cannot read '" + job.input + "': segment " + label_text(missing) + " (" +
                       missing.name + ") is empty.");
  }
  std::string labels;
  for (const LabelSummary& label : map.labels()) {
    if (labels.size() > 60) {
      labels += ", ...";
      break;
    }
    labels += (labels.empty() ? "" : ", ") + label_text({.value = label.value});
  }
  throw MissingLabel(
      "Cannot read '" + job.input + "': label " + label_text(missing) + " does not occur in it. " +
      (labels.empty() ? "All of its samples are 0" : "Its labels are " + labels) + ".");
}

// Simplification shrinks thin parts even if its error is less than a quarter of their thickness.
void warn_of_thin_parts(const PrepareJob& job, const LabelSummary& label,
                        const VolumeFileOptions& options) {
  constexpr std::uint64_t kNoticeDivisor = 10;  // A part of 1 / 10 or more.
  if (!options.notice || label.thin_samples * kNoticeDivisor < label.samples) return;
  options.notice("'" + job.input + "': of the " + std::to_string(label.samples) +
                 " voxels of label " + label_text({.value = label.value}) + " " +
                 std::to_string(label.thin_samples) +
                 " are in parts one voxel thick; an error above 0.25 voxels reduces their volume.");
}

// What a microscope sees has no upper side.
bool is_microscopic(std::string_view length_unit) {
  return length_unit == "µm" || length_unit == "nm" || length_unit == "Å";
}

struct OpenedJob {
  std::unique_ptr<VolumeSource> source;
  std::optional<LabelVolume> label_volume = std::nullopt;
  double beyond_ends = kBeyondEnds;  // The value of a label's margin.
};

OpenedJob open_job(const PrepareJob& job, const VolumeFileOptions& options, LatestLabelMap& maps) {
  if (!job.member || !job.member->label) return {open_volume(job.input, options)};
  const double value = job.stored_label;
  const LabelMap map = maps.of(job.input, options);
  if (value == 0) return {map.field(value)};
  const auto found = std::find_if(map.labels().begin(), map.labels().end(),
                                  [&](const LabelSummary& label) { return label.value == value; });
  if (found == map.labels().end()) fail_without_label(job, map);
  warn_of_thin_parts(job, *found, options);
  OpenedJob opened{map.field(value),
                   LabelVolume{.samples = found->samples,
                               .surface_samples = found->surface_samples,
                               .place = LabelExtent::Place{.least = found->least,
                                                           .greatest = found->greatest,
                                                           .centroid = found->centroid}}};
  if (!meets_end(*found, opened.source->header().dims)) opened.beyond_ends = 0;
  return opened;
}

}  // namespace

LabelMap LatestLabelMap::of(const std::string& input, const VolumeFileOptions& options) {
  if (map_ && input_ == input && choice_ == options.choice) return *map_;
  map_.reset();
  VolumeFileOptions of_labels = options;
  of_labels.choice.nearest = true;
  const auto source = open_volume(input, of_labels);
  try {
    map_.emplace(input, *source, folder_, ends_, stop_);
  } catch (const Cancelled&) {
    throw PreparationStopped();
  }
  input_ = input;
  choice_ = options.choice;
  return *map_;
}

void require_free_output(const PrepareJob& job) {
  if (is_address(job.output.string())) return;
  require_outputs({{"--output", job.output}}, {{"input", job.input}});
}

namespace {

// Prevents accidental replacement of a dataset from another source, except one of the same series.
void require_same_source(const PrepareJob& job, const Provenance& note) {
  if (is_address(job.output.string()) || !std::filesystem::exists(job.output)) return;
  std::optional<DatasetMetadata> previous;
  try {
    previous = PreparedFile(job.output.string()).metadata();
  } catch (const std::exception&) {
    return;  // A damaged dataset may be replaced.
  }
  const bool has_same_source = previous->source.file == note.file ||
                               (!note.digest.empty() && previous->source.digest == note.digest);
  const bool is_same_series =
      job.member && previous->info.member && job.member->series == previous->info.member->series;
  if (has_same_source || is_same_series) return;
  throw ExitError(kUsage, "--output: " + job.output.string() + " is a dataset prepared from '" +
                              previous->source.file + "'; --force replaces it with one from '" +
                              note.file + "'.");
}

}  // namespace

std::optional<PrepareResult> Preparation::prepare_unless_up_to_date(const PrepareJob& job) {
  if (is_dataset_file(job.input)) {
    if (PreparedFile(job.input).info().missing.empty()) return std::nullopt;
    DatasetOutput output(job.output, arguments_.force);
    return complete_one(job.input, output);
  }
  require_free_output(job);
  DatasetOutput output(job.output, arguments_.force);
  const Provenance note = provenance_of(job);
  if (arguments_.force || !is_up_to_date(job, note)) return prepare_one(job, note, output);
  check_prepared_grid(job);
  const std::string output_path = job.output.string();
  if (arguments_.samples_only || PreparedFile(output_path).info().missing.empty())
    return std::nullopt;
  return complete_one(output_path, output);
}

namespace {

// Returns a function that shows the progress of prepare(), and throws PreparationStopped.
auto shown_in(Progress& progress, const std::stop_token& stop) {
  return
      [&, pass = std::string()](const char* name, std::uint64_t done, std::uint64_t all) mutable {
        if (stop.stop_requested()) throw PreparationStopped();
        if (pass != name) progress.begin(pass = name);
        progress.update(static_cast<double>(done), static_cast<double>(all), "voxels");
      };
}

// Uploads the output if it is in a bucket.
void finish(DatasetOutput& output, Progress& progress, PrepareResult& result) {
  bool has_begun = false;
  output.finish([&](double fraction) {
    if (!std::exchange(has_begun, true)) progress.begin("upload");
    progress.update(100 * fraction, 100, "%");
  });
  progress.finish();
  result.file_bytes = std::filesystem::file_size(output.file());
  result.seconds = progress.seconds();
}

[[noreturn]] void refuse_volume(const PrepareJob& job, const std::string& reason) {
  throw std::invalid_argument("'" + job.input + "': " + reason + ".");
}

}  // namespace

PrepareResult Preparation::complete_one(const std::string& dataset, DatasetOutput& output,
                                        const ForEach& for_each) {
  Progress progress("prepare", 1, arguments_.quiet || arguments_.json, /*prints_stages=*/true);
  PrepareResult completed;
  try {
    completed.info = complete(
        dataset, {.for_each = for_each, .stop = stop_, .progress = shown_in(progress, stop_)},
        output.file());
  } catch (const Cancelled&) {
    throw PreparationStopped();
  }
  finish(output, progress, completed);
  return completed;
}

PrepareResult Preparation::prepare_one(const PrepareJob& job, const Provenance& note,
                                       DatasetOutput& output) {
  if (!arguments_.force) require_same_source(job, note);
  const bool is_label = job.member && job.member->label;
  std::optional<double> outside = arguments_.outside_value();
  const std::int32_t margin = arguments_.margin_steps();
  Progress progress(job.member ? "prepare " + job.name : "prepare", 3,
                    arguments_.quiet || arguments_.json, /*prints_stages=*/!job.member);
  progress.begin("open");
  VolumeFileOptions options = arguments_.volume.parsed();
  options.choice = job.choice;
  options.notice = [&](const std::string& text) { progress.print_above_bar(text); };
  if (outside && margin == 0) {
    options.notice(
        "--pad-value alone leaves surfaces open where the grid ends; --pad 1 closes them.");
  }
  const OpenedJob opened = open_job(job, options, maps_);
  if (is_label && outside) outside = opened.beyond_ends;
  const VolumeHeader& header = opened.source->header();
  const bool is_closed = outside && margin > 0;
  if (!is_closed && std::find(header.dims.begin(), header.dims.end(), 1) != header.dims.end()) {
    refuse_volume(
        job,
        "it has " + sides_text(header.dims) +
            " samples: a single slice has no surface. --pad-value VALUE --pad 1 surrounds it with "
            "a value and gives it one");
  }
  check_grid(job, {header.dims, header.index_to_world, header.meaning});
  const bool may_lie = header.meaning.space == WorldSpace::kUnnamed &&
                       !is_microscopic(header.meaning.length_unit) &&
                       arguments_.volume.orient.empty() && arguments_.volume.space.empty();
  if (may_lie && !std::exchange(has_noted_axes_, true)) {
    options.notice("'" + job.input +
                   "' does not say which axis is up, so z is. If it is upside down, add: --orient "
                   "x,-y,-z");
  }
  PrepareOptions how{.name = job.name,
                     .outside = outside,
                     .margin = margin,
                     .bins = arguments_.bins,
                     .member = job.member,
                     .label_volume = opened.label_volume,
                     .samples_only = arguments_.samples_only};
  if (is_label) {
    how.suggested_isovalues = {kLabelBoundary};
    how.bin_edges = {kLabelBinEdges.begin(), kLabelBinEdges.end()};
  }
  how.progress = [&, show = shown_in(progress, stop_)](const char* pass, std::uint64_t done,
                                                       std::uint64_t all) mutable {
    show(pass, done, all);
    if (arguments_.reading && all > 0) {
      arguments_.reading(job.name, static_cast<double>(done) / static_cast<double>(all));
    }
  };
  how.accept = [&](const DatasetInfo& info) {
    std::uint64_t samples = 1;
    for (const std::int32_t side : info.dims) samples *= static_cast<std::uint64_t>(side);
    if (info.void_samples == samples) {
      refuse_volume(job, "all its samples are void (NaN, or missing), so it has no surface");
    }
  };
  PrepareResult prepared;
  prepared.info = prepare(*opened.source, how, output.file(), note);
  prepared.label_volume = opened.label_volume;
  finish(output, progress, prepared);
  return prepared;
}

Provenance Preparation::provenance_of(const PrepareJob& job) {
  auto [at, is_new] = provenances_.try_emplace(job.input);
  if (is_new) at->second = provenance(job.input);
  Provenance note = at->second;
  note.options = arguments_.command_line();
  for (const std::string& more : job.command_line)
    note.options += (note.options.empty() ? "" : " ") + more;
  return note;
}

void Preparation::check_prepared_grid(const PrepareJob& job) {
  if (!job.member) return;
  const DatasetInfo info = PreparedFile(job.output.string()).info();
  check_grid(job, {info.dims, info.index_to_world, info.meaning});
}

// Fails for a member whose grid differs from that of the first one.
void Preparation::require_same_placement(const PrepareJob& job, const GridPlacement& found,
                                         const GridPlacement& first,
                                         const std::string& first_input) {
  const auto refuse = [&](const std::string& difference) {
    fail_reading(job.input, difference + "; members of a series must have the same grid",
                 "Resample it, or prepare it separately");
  };
  if (found.dims != first.dims) {
    refuse("it has " + sides_text(found.dims) + " samples and '" + first_input + "' has " +
           sides_text(first.dims));
  }
  if (found.index_to_world != first.index_to_world || found.meaning.space != first.meaning.space ||
      found.meaning.length_unit != first.meaning.length_unit) {
    refuse("its samples have other world positions than those of '" + first_input + "'");
  }
}

void Preparation::check_grid(const PrepareJob& job, const GridPlacement& placement) {
  if (!job.member) return;
  const auto [first, is_new] = first_.try_emplace(job.member->series, placement, job.input);
  if (!is_new) require_same_placement(job, placement, first->second.first, first->second.second);
}

}  // namespace multitetra
