#include "server/programs/prepare/prepare_arguments.hpp"

#include <cmath>
#include <cstddef>
#include <set>

#include "common/base/exit_codes.hpp"
#include "common/base/parse_number.hpp"
#include "common/dataset/physical_meaning.hpp"
#include "common/dataset/series_member.hpp"
#include "server/programs/prepare/prepare_jobs.hpp"

namespace multitetra {
namespace {

[[noreturn]] void throw_usage_error(const std::string& text) { throw ExitError(kUsage, text); }

[[noreturn]] void throw_invalid_times(const std::string& times) {
  throw_usage_error(
      "--times: \"" + times +
      "\" is not a list of times; write increasing numbers, such as 0,0.1,0.3, or the first "
      "and the step, such as 0:0.1.");
}

void require_unique(const std::vector<std::string>& values, const char* option) {
  std::set<std::string> seen;
  for (const std::string& value : values) {
    if (value == "all" && values.size() > 1)
      throw_usage_error(std::string(option) + ": \"all\" cannot be combined with names.");
    if (!seen.insert(value).second)
      throw_usage_error(std::string(option) + ": " + value + " is given twice.");
  }
}

// Labels end at the border of the data, as most segmented objects are complete.
const char* default_outside(const SeriesArguments& series) {
  return series.labels.empty() ? "void" : "0";
}
int default_margin(const SeriesArguments& series) { return series.labels.empty() ? 0 : 1; }

}  // namespace

bool PrepareArguments::makes_several() const {
  return series.are_given() || (!inputs.empty() && has_several_volumes(inputs));
}

std::optional<double> PrepareArguments::outside_value() const {
  return outside_from(outside.empty() ? default_outside(series) : outside);
}

std::int32_t PrepareArguments::margin_steps() const {
  return margin.value_or(default_margin(series));
}

LabelEnds PrepareArguments::label_ends() const {
  return outside_value() && margin_steps() > 0 ? LabelEnds::kClosed : LabelEnds::kOpen;
}

std::string PrepareArguments::command_line() const {
  std::string text = volume.command_line();
  const auto add_text = [&](const char* option, const std::string& value,
                            const std::string& default_value) {
    if (value != default_value) text += std::string(text.empty() ? "" : " ") + option + " " + value;
  };
  const std::string default_value = default_outside(series);
  // Datasets keep the former names of --pad-value and --pad, so that their sources compare equal.
  add_text("--outside", outside.empty() ? default_value : outside, default_value);
  add_text("--margin", std::to_string(margin_steps()), std::to_string(default_margin(series)));
  add_text("--bins", std::to_string(bins), std::to_string(IsovalueBins::kDefaultCount));
  return text;
}

void SeriesArguments::add_to(Command& command) {
  command
      .add_option(
          "--label", labels,
          "A dataset for each of these labels of a label map, or all; each is a smooth field whose "
          "isosurface 0.5 is the label's boundary, and all is every label except 0. If segments "
          "overlap, as in .seg.nrrd with several layers, labels are their numbers, from 1")
      ->delimiter(',')
      ->repeatable()
      ->type_name("LABEL,...");
  command
      .add_option("--label-names", label_names,
                  "Names and colors of labels; a file from ITK-SNAP or 3D Slicer")
      ->type_name("FILE");
  command.add_flag("--all-times", all_times, "A dataset for each of the volume's times");
  command
      .add_option("--field", fields,
                  "A dataset for each of these fields, or all; fields are arrays of one shape, or "
                  "channels")
      ->delimiter(',')
      ->repeatable()
      ->type_name("NAME,...");
  command
      .add_option("--time-series", time_series,
                  "The volumes are times of one series of this name; in natural order")
      ->type_name("NAME");
  command
      .add_option("--times", times,
                  "Times of the series, or the first and the step as 0:0.1; default: those of the "
                  "files, or 0, 1, 2, ...")
      ->type_name("TIMES");
  command.add_option("--time-unit", time_unit, "Unit of the times, such as s")
      ->type_name("UNIT")
      ->group("Series");
}

void SeriesArguments::check() const {
  require_unique(labels, "--label");
  require_unique(fields, "--field");
  require_unique(components, "--component");
  if (!label_names.empty() && labels.empty()) throw_usage_error("--label-names requires --label.");
  if (all_times && !time_series.empty()) {
    throw_usage_error(
        "--all-times is for one volume with several times, --time-series for volumes of one time "
        "each; give one of them.");
  }
  const bool has_times = all_times || !time_series.empty();
  if (!times.empty() && !has_times)
    throw_usage_error("--times requires --time-series or --all-times.");
  if (!time_unit.empty() && !has_times)
    throw_usage_error("--time-unit requires --time-series or --all-times.");
  if (!is_unit_text(time_unit)) {
    throw_usage_error("--time-unit must be UTF-8 of at most " + std::to_string(kMaxUnitBytes) +
                      " bytes without control characters.");
  }
  if (!time_series.empty() && !check_member({.series = time_series})) {
    throw_usage_error(
        "--time-series must have 1 to 255 bytes of UTF-8, no '/' and no control characters.");
  }
  if (!wants_all_labels()) (void)label_values();
}

std::vector<double> SeriesArguments::label_values() const {
  std::vector<double> values;
  for (const std::string& label : labels) {
    const std::optional<double> value = parse_finite(label);
    constexpr double kFirstInexactLabel = 16'777'216;
    if (value && std::abs(*value) >= kFirstInexactLabel) {
      throw_usage_error("--label: " + label +
                        " is not below 2^24; renumber the labels from 1, as with "
                        "skimage.segmentation.relabel_sequential or fastremap.renumber.");
    }
    if (!value || std::trunc(*value) != *value) {
      throw_usage_error("--label: \"" + label +
                        "\" is not a list of labels; write integers such as 3,7, or all.");
    }
    values.push_back(*value + 0.0);  // Turns -0 into 0.
  }
  return values;
}

std::vector<double> SeriesArguments::time_values(std::size_t count) const {
  std::vector<double> values;
  if (times.empty()) return values;
  const std::size_t colon = times.find(':');
  if (colon != std::string::npos) {
    const auto first = parse_finite(std::string_view(times).substr(0, colon));
    const auto step = parse_finite(std::string_view(times).substr(colon + 1));
    if (!first || !step || !(*step > 0)) throw_invalid_times(times);
    for (std::size_t i = 0; i < count; ++i) {
      values.push_back(*first + *step * static_cast<double>(i));
    }
  } else {
    auto numbers = parse_number_list<double>(times, 1, SIZE_MAX);
    if (!numbers) throw_invalid_times(times);
    values = *std::move(numbers);
  }
  if (values.size() != count) {
    throw_usage_error("--times has " + std::to_string(values.size()) + " numbers, but there are " +
                      std::to_string(count) + " times.");
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(values[i]) || (i > 0 && !(values[i] > values[i - 1])))
      throw_invalid_times(times);
  }
  return values;
}

}  // namespace multitetra
