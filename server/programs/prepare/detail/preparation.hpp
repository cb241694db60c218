// Prepares a dataset from a volume: one job of `prepare`.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <utility>

#include "common/base/json.hpp"
#include "common/json/json_report.hpp"
#include "server/core/framework/for_each.hpp"
#include "server/dataset/dataset_metadata.hpp"
#include "server/programs/prepare/dataset_output.hpp"
#include "server/programs/prepare/prepare_arguments.hpp"
#include "server/programs/prepare/prepare_jobs.hpp"
#include "server/volume/labels/label_map.hpp"

namespace multitetra {

// Caches the latest label map, as labels of one map are prepared one after the other.
class LatestLabelMap {
 public:
  LatestLabelMap(std::filesystem::path scratch_folder, LabelEnds ends, std::stop_token stop = {})
      : folder_(std::move(scratch_folder)), ends_(ends), stop_(std::move(stop)) {}

  // Throws VolumeFileError, DatasetFileError, PreparationStopped.
  [[nodiscard]] LabelMap of(const std::string& input, const VolumeFileOptions& options);

 private:
  std::filesystem::path folder_;
  LabelEnds ends_;
  std::stop_token stop_;
  std::string input_;
  VolumeChoice choice_;
  std::optional<LabelMap> map_;
};

// A job's label does not occur in its map. Not a failure in a time series.
class MissingLabel : public VolumeFileError {
 public:
  using VolumeFileError::VolumeFileError;
};

// The stop token ended a preparation; nothing was written.
class PreparationStopped : public std::runtime_error {
 public:
  PreparationStopped() : std::runtime_error("The preparation was stopped.") {}
};

// Throws ExitError (kUsage) if the job's output is its input or cannot be written.
void require_free_output(const PrepareJob& job);

struct PrepareResult {
  DatasetInfo info;
  std::optional<LabelVolume> label_volume = std::nullopt;
  std::uint64_t file_bytes = 0;
  Json seconds;
};

// Prepares jobs one by one. Members of one series must have the same grid. Keeps references to its
// arguments.
class Preparation {
 public:
  Preparation(const PrepareArguments& arguments, LatestLabelMap& maps, std::stop_token stop = {})
      : arguments_(arguments), maps_(maps), stop_(std::move(stop)) {}

  // Throws VolumeFileError or MissingLabel if the source cannot be read; PreparationStopped,
  // DatasetFileError, StoreError.
  PrepareResult prepare_one(const PrepareJob& job, const Provenance& note, DatasetOutput& output);

  // Computes the errors of a dataset without them, on the threads of `for_each` (null: on all).
  // Throws DatasetFileError, StoreError, PreparationStopped.
  PrepareResult complete_one(const std::string& dataset, DatasetOutput& output,
                             const ForEach& for_each = nullptr);

  // Skips a dataset that is up to date, unless `force` is set. Completes one that lacks errors,
  // unless only samples are wanted.
  std::optional<PrepareResult> prepare_unless_up_to_date(const PrepareJob& job);

  // Returns the provenance of a job's source. Reads each source once for all its jobs.
  [[nodiscard]] Provenance provenance_of(const PrepareJob& job);

 private:
  // The placement of samples, common to the members of a series.
  struct GridPlacement {
    std::array<std::int32_t, 3> dims{};
    Affine index_to_world;
    PhysicalMeaning meaning;
  };
  void check_grid(const PrepareJob& job, const GridPlacement& placement);
  // Checks the placement of a dataset that is up to date. Throws if it differs.
  void check_prepared_grid(const PrepareJob& job);
  static void require_same_placement(const PrepareJob& job, const GridPlacement& found,
                                     const GridPlacement& first, const std::string& first_input);

  const PrepareArguments& arguments_;
  LatestLabelMap& maps_;
  std::stop_token stop_;
  // Whether the notice was given that a volume without a space may not be upright.
  bool has_noted_axes_ = false;
  std::map<std::string, Provenance> provenances_;
  // The first member's placement and input, by series.
  std::map<std::string, std::pair<GridPlacement, std::string>> first_;
};

}  // namespace multitetra
