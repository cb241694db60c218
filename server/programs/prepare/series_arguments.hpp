// The options of `prepare` for series: which labels, times and fields become datasets.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/cli/command.hpp"

namespace multitetra {

struct SeriesArguments {
  std::vector<std::string> labels;  // Numbers, or just "all".
  std::string label_names;          // A file path.
  bool all_times = false;
  std::vector<std::string> fields;  // Names, or just "all".
  std::vector<std::string> components;
  std::string time_series;  // The series' name.
  std::string times;        // "0,0.1,0.3" or "0:0.1".
  std::string time_unit;

  void add_to(Command& command);
  // Throws ExitError (kUsage) for conflicting options.
  void check() const;

  // Returns whether the options make a series of a volume.
  [[nodiscard]] bool are_given() const {
    return !labels.empty() || all_times || !fields.empty() || !components.empty() ||
           !time_series.empty();
  }
  [[nodiscard]] bool wants_all_labels() const { return labels == std::vector<std::string>{"all"}; }
  [[nodiscard]] bool wants_all_fields() const { return fields == std::vector<std::string>{"all"}; }
  // Requires that not all labels are selected. Throws ExitError (kUsage) unless all are integers.
  [[nodiscard]] std::vector<double> label_values() const;
  // Returns `count` times; none without --times. Throws ExitError (kUsage) unless --times has
  // `count` increasing numbers.
  [[nodiscard]] std::vector<double> time_values(std::size_t count) const;
};

}  // namespace multitetra
