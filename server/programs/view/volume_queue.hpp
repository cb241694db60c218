// Prepares the volumes that `view` and `serve` show while they are served: the samples of all of
// them first, then their errors.
//
//   VolumeQueue volumes({"head.nrrd"}, {});
//   const std::optional<std::string> first = volumes.prepare_next({});
//   ... serve volumes.datasets() ...
//   const auto rest = volumes.run_behind(read_again);
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "server/programs/prepare/detail/preparation.hpp"
#include "server/programs/view/dataset_cache.hpp"

namespace multitetra {

struct VolumeQueueOptions {
  const char* command = "view";  // Begins messages.
  VolumeOptions volume = {};
  std::string outside = {};        // Empty: void.
  std::optional<int> margin = {};  // None: 0.
  std::string labels = {};         // A label map or a dataset.
  std::string label_names = {};
  bool no_labels = false;
  std::string cache_folder = {};  // Empty: default_cache_folder().
  std::uint64_t cache_bytes = std::uint64_t{20} << 30;
  bool no_cache = false;
  bool quiet = false;
};

// Not thread-safe.
class VolumeQueue {
 public:
  // `inputs` are volumes and datasets. Reads the headers of volumes, and all their bytes for the
  // names of cache entries. Throws VolumeFileError, ExitError.
  VolumeQueue(std::vector<std::string> inputs, VolumeQueueOptions options);
  ~VolumeQueue();

  // Returns whether any input was already a dataset.
  [[nodiscard]] bool has_datasets() const { return has_datasets_; }

  // Returns the paths of the datasets, including those not yet prepared.
  [[nodiscard]] const std::vector<std::string>& datasets() const { return datasets_; }

  // Prepares samples until one dataset is there. Returns its name, or none at the end. Prints
  // failures to stderr. Throws PreparationStopped.
  std::optional<std::string> prepare_next(const std::stop_token& stop);

  // Prepares the rest on a thread until it is destroyed, then computes errors on threads that
  // requests do not need. Calls `changed` for every dataset. The queue must outlive the thread.
  [[nodiscard]] std::shared_ptr<std::jthread> run_behind(std::function<void()> changed);

 private:
  class Folders;
  struct Work;

  // Adds the errors to the next prepared dataset that lacks them. Returns false at the end.
  bool complete_next(const std::stop_token& stop);
  void print_line(const std::string& text) const;
  void add(PrepareArguments arguments);
  void add_labels_of(const std::string& input);
  void wait_for(PrepareArguments arguments);
  bool prepare(const PrepareJob& job);
  void report_other_grid(const std::string& input, const DatasetInfo& labels) const;

  VolumeQueueOptions options_;
  std::optional<DatasetInfo> first_;  // The first one prepared.
  std::unique_ptr<Folders> folders_;
  std::vector<std::string> datasets_;
  bool has_datasets_ = false;
  // The first one is in progress.
  std::deque<PrepareArguments> waiting_;
  std::unique_ptr<Work> work_;
  std::deque<std::string> without_errors_;  // Paths of prepared datasets.
};

}  // namespace multitetra
