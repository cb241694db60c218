// Volumes into datasets, one after another: what is made, left alone and told.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/programs/prepare/prepare_arguments.hpp"
#include "server/programs/prepare/prepare_jobs.hpp"
#include "server/volume/labels/label_map.hpp"

namespace multitetra {

// The label map that was read last: labels of one map are prepared one after another.
class LatestLabelMap {
 public:
  explicit LatestLabelMap(std::filesystem::path scratch_folder)
      : folder_(std::move(scratch_folder)) {}

  // Throws VolumeFileError, DatasetFileError.
  [[nodiscard]] LabelMap of(const std::string& input, const VolumeFileOptions& options);

 private:
  std::filesystem::path folder_;
  std::string input_;
  VolumeChoice choice_;
  std::optional<LabelMap> map_;
};

// One volume, into one dataset. Returns the exit code. Throws ExitError when it cannot be read.
int prepare_single(const PrepareArguments& arguments, const PrepareJob& job);

// Goes on after a failure; what is up to date is not made again. Ends with a table.
int prepare_all(const PrepareArguments& arguments, const std::vector<PrepareJob>& jobs,
                LatestLabelMap& maps);

}  // namespace multitetra
