// A volume into a dataset: one job of `prepare`.
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

#include <nlohmann/json.hpp>

#include "common/cli/json_report.hpp"
#include "server/dataset/dataset_metadata.hpp"
#include "server/programs/prepare/dataset_output.hpp"
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

// The label of a job does not occur in its map. In a time series that is no failure.
class MissingLabel : public VolumeFileError {
 public:
  using VolumeFileError::VolumeFileError;
};

// A preparation ended because its stop token was set; nothing was written.
class PreparationStopped : public std::runtime_error {
 public:
  PreparationStopped() : std::runtime_error("The preparation was stopped.") {}
};

// Few different values in an integer volume are mostly labels.
[[nodiscard]] bool looks_like_labels(const DatasetInfo& info);

// Throws ExitError (kUsage) when the job's output is its input, or cannot be written.
void require_free_output(const PrepareJob& job);

struct PrepareResult {
  DatasetInfo info;
  std::optional<LabelVolume> label_volume = std::nullopt;
  std::uint64_t file_bytes = 0;
  Json seconds;
};

// Prepares jobs one by one. Those of one series must lie on the same places. Keeps references to
// its arguments.
class Preparation {
 public:
  Preparation(const PrepareArguments& arguments, LatestLabelMap& maps, std::stop_token stop = {})
      : arguments_(arguments), maps_(maps), stop_(std::move(stop)) {}

  // Throws VolumeFileError or MissingLabel when the source cannot be read, PreparationStopped,
  // DatasetFileError, StoreError.
  PrepareResult prepare_one(const PrepareJob& job, const Provenance& note, DatasetOutput& output);

  // The same unless the job's dataset is up to date, where `force` does not ask for a new one.
  std::optional<PrepareResult> prepare_unless_up_to_date(const PrepareJob& job);

  // The note of a job's source. The bytes of a source are read once, however many jobs it has.
  [[nodiscard]] Provenance note_of(const PrepareJob& job);

 private:
  // The placement of a series' members, which share their grid.
  struct Places {
    std::array<std::int32_t, 3> dims{};
    Affine index_to_world;
    PhysicalMeaning meaning;
  };
  void see(const PrepareJob& job, const Places& places);
  // A job whose dataset is there already. Throws unless it lies on the same places.
  void see_prepared(const PrepareJob& job);
  static void require_same_places(const PrepareJob& job, const Places& found, const Places& first,
                                  const std::string& first_input);

  const PrepareArguments& arguments_;
  LatestLabelMap& maps_;
  std::stop_token stop_;
  std::map<std::string, Provenance> notes_;
  std::map<std::string, std::pair<Places, std::string>> first_;  // By series, with its input.
};

}  // namespace multitetra
