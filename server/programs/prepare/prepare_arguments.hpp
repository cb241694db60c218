// The options of `prepare`.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "server/core/spectrum/isovalue_bins.hpp"
#include "server/programs/prepare/prepare_parts_command.hpp"
#include "server/programs/prepare/series_arguments.hpp"
#include "server/programs/volume_options.hpp"
#include "server/volume/labels/label_map.hpp"

namespace multitetra {

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

  // Throws std::invalid_argument unless `outside` is "void" (returns none) or a number.
  [[nodiscard]] std::optional<double> outside_value() const;
  [[nodiscard]] std::int32_t margin_steps() const;
  [[nodiscard]] LabelEnds label_ends() const;
  // Returns the options that affect the dataset, as text for comparison.
  [[nodiscard]] std::string command_line() const;
};

}  // namespace multitetra
