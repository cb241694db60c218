#include "server/programs/prepare/label_jobs.hpp"

#include <algorithm>
#include <utility>

#include "common/base/exit_codes.hpp"
#include "server/volume/labels/label_names.hpp"
#include "server/volume/volume_files.hpp"

namespace multitetra {
namespace {

PrepareJob job_of_label(const PrepareJob& volume, const Label& label, double stored) {
  PrepareJob job = volume;
  job.member->label = label;
  job.stored_label = stored;
  job.name += ".label" + label_text(label);
  job.command_line.push_back("--label " + label_text(label));
  return job;
}

[[noreturn]] void fail_without_labels(const std::string& input) {
  throw ExitError(kUsage, "'" + input + "' has no labels: all of its samples are 0.");
}

}  // namespace

LabelJobs::LabelJobs(const PrepareArguments& arguments, LatestLabelMap& maps,
                     const std::string& input, std::vector<SourceLabel> named)
    : arguments_(arguments), maps_(maps), named_(std::move(named)) {
  const SeriesArguments& requested = arguments.series;
  has_layers_ =
      have_layers(named_) && arguments.volume.component.empty() && requested.components.empty();
  if (has_layers_ && !requested.labels.empty()) {
    notice_ =
        "'" + input +
        "' has segments in several layers: the numbers of the segments are used as labels, 1 to " +
        std::to_string(named_.size()) + ".";
  }
  if (requested.label_names.empty()) return;
  for (Label& label : read_label_names(requested.label_names))
    renamed_[label.value] = std::move(label);
}

std::vector<PrepareJob> LabelJobs::of(const PrepareJob& volume) const {
  if (arguments_.series.labels.empty()) return {volume};
  return has_layers_ ? of_layers(volume) : of_map(volume);
}

std::vector<PrepareJob> LabelJobs::of_map(const PrepareJob& volume) const {
  const bool wants_all = arguments_.series.wants_all_labels();
  const std::vector<double> values =
      wants_all ? found_in(volume) : arguments_.series.label_values();
  if (values.size() > kMaxLabelsAtOnce && wants_all) {
    throw ExitError(kUsage, "'" + volume.input + "' has " + std::to_string(values.size()) +
                                " labels; --label all prepares a dataset of each, for at most " +
                                std::to_string(kMaxLabelsAtOnce) +
                                ". Select some of them, such as --label 3,7.");
  }
  if (values.empty()) fail_without_labels(volume.input);
  std::vector<PrepareJob> jobs;
  for (const double value : values) {
    jobs.push_back(job_of_label(volume, label_of(value, volume.choice.component.index), value));
  }
  return jobs;
}

std::vector<PrepareJob> LabelJobs::of_layers(const PrepareJob& volume) const {
  std::map<int, std::vector<SourceLabel>> layers;
  for (const SourceLabel& segment : wanted_segments(volume.input)) {
    layers[segment.layer].push_back(segment);
  }
  std::vector<PrepareJob> jobs;
  for (const auto& [layer, segments] : layers) {
    PrepareJob map = volume;  // Each layer is a label map.
    map.choice.component = {.kind = ComponentChoice::Kind::kIndex, .index = layer};
    // --label all skips empty labels.
    std::vector<double> present;
    if (arguments_.series.wants_all_labels()) present = found_in(map);
    for (const auto& [label, stored, of_layer] : segments) {
      const bool is_there = std::find(present.begin(), present.end(), stored) != present.end();
      if (arguments_.series.wants_all_labels() && !is_there) continue;
      jobs.push_back(job_of_label(map, renamed(label), stored));
    }
  }
  if (jobs.empty()) fail_without_labels(volume.input);
  return jobs;
}

std::vector<SourceLabel> LabelJobs::wanted_segments(const std::string& input) const {
  if (arguments_.series.wants_all_labels()) return named_;
  std::vector<SourceLabel> segments;
  for (const double number : arguments_.series.label_values()) {
    const auto found = std::find_if(named_.begin(), named_.end(), [&](const SourceLabel& segment) {
      return segment.label.value == number;
    });
    if (found == named_.end()) {
      throw ExitError(kUsage, "'" + input + "' has no segment " + label_text({.value = number}) +
                                  "; it has 1 to " + std::to_string(named_.size()) + ".");
    }
    segments.push_back(*found);
  }
  return segments;
}

// Returns the label named by the source, or one named by its number.
Label LabelJobs::label_of(double value, int layer) const {
  const auto found = std::find_if(named_.begin(), named_.end(), [&](const SourceLabel& segment) {
    return segment.stored == value && segment.layer == layer;
  });
  if (found == named_.end()) {
    return renamed({.value = value, .name = "label " + label_text({.value = value})});
  }
  Label label = found->label;
  label.value = value;
  return renamed(label);
}

Label LabelJobs::renamed(const Label& label) const {
  const auto found = renamed_.find(label.value);
  return found == renamed_.end() ? label : found->second;
}

std::vector<double> LabelJobs::found_in(const PrepareJob& volume) const {
  VolumeFileOptions options = arguments_.volume.parsed();
  options.choice = volume.choice;
  const LabelMap map = maps_.of(volume.input, options);
  std::vector<double> values;
  for (const LabelSummary& label : map.labels()) values.push_back(label.value);
  return values;
}

}  // namespace multitetra
