#include "server/programs/prepare/prepare_arguments.hpp"

namespace multitetra {
namespace {

// Labels end at the border of the data, as most segmented objects are complete.
const char* default_outside(const SeriesArguments& series) {
  return series.labels.empty() ? "void" : "0";
}
int default_margin(const SeriesArguments& series) { return series.labels.empty() ? 0 : 1; }

}  // namespace

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

}  // namespace multitetra
