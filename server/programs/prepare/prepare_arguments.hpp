// The options of `prepare`.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/core/spectrum/isovalue_bins.hpp"
#include "server/programs/prepare/prepare_parts_command.hpp"
#include "server/programs/volume_options.hpp"
#include "server/volume/labels/label_map.hpp"

namespace multitetra {

// Which labels, times and fields become datasets of a series.
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

struct PrepareArguments {
  std::vector<std::string> inputs;
  std::string output;
  std::string name;
  std::string outside;        // Empty: void; 0 around labels.
  std::optional<int> margin;  // None: 0; 1 around labels, closing them.
  VolumeOptions volume;
  SeriesArguments series;
  PartsArguments parts;
  int bins = IsovalueBins::kDefaultCount;
  bool samples_only = false;
  int threads = 0;
  bool force = false;
  bool json = false;
  bool quiet = false;
  // Called with the part of a volume's samples that is read, 0 to 1.
  std::function<void(const std::string& dataset, double share)> reading;

  // Returns whether they make a series, or datasets of several volumes.
  [[nodiscard]] bool makes_several() const;
  // Throws std::invalid_argument unless `outside` is "void" (returns none) or a number.
  [[nodiscard]] std::optional<double> outside_value() const;
  [[nodiscard]] std::int32_t margin_steps() const;
  [[nodiscard]] LabelEnds label_ends() const;
  // Returns the options that affect the dataset, as text for comparison.
  [[nodiscard]] std::string command_line() const;
};

}  // namespace multitetra
