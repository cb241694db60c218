// Prepares the volumes that `view` and `serve` show while they are served: the samples of all of
// them first, then their errors.
//
//   VolumeQueue volumes({"head.nrrd"}, {});
//   if (!volumes.begin()) ...                              // Nothing can be shown.
//   ... serve volumes.datasets() and volumes.readings() ...
//   const auto rest = volumes.run_behind(read_again, stop);
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "server/programs/prepare/detail/preparation.hpp"
#include "server/programs/view/dataset_cache.hpp"
#include "server/service/dataset_catalogue.hpp"

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

// The functions are called from one thread; the work is done on another.
class VolumeQueue {
 public:
  // `inputs` are volumes and datasets. Reads the headers of volumes, and all their bytes for the
  // names of cache entries. Throws VolumeFileError, ExitError.
  VolumeQueue(std::vector<std::string> inputs, VolumeQueueOptions options);
  ~VolumeQueue();

  // Returns the paths of the datasets, including those not yet prepared.
  [[nodiscard]] const std::vector<std::string>& datasets() const { return datasets_; }

  // Begins to prepare samples, and then errors on threads that requests do not need. Returns when
  // the first dataset is there, or after 0.3 s, so that a page opens soon. Returns false if every
  // volume was tried already and none could be prepared. Prints failures to stderr.
  [[nodiscard]] bool begin();

  // Returns the first dataset's name, also while it is read; none if it is unknown yet.
  [[nodiscard]] std::optional<std::string> first() const;

  // Returns what is being read, as long as the queue exists.
  [[nodiscard]] ReadingsSource readings() const;

  // Calls `changed` for every further dataset, and `finished` once all volumes were tried, until
  // the result is destroyed; that ends the work.
  [[nodiscard]] std::shared_ptr<void> run_behind(std::function<void()> changed,
                                                 std::function<void()> finished);

 private:
  class Folders;
  struct Work;

  // Prepares samples until one dataset is there. Returns its name, or none at the end. Throws
  // PreparationStopped.
  std::optional<std::string> prepare_next(const std::stop_token& stop);
  void run(const std::stop_token& stop);
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
  // The first one is in progress.
  std::deque<PrepareArguments> waiting_;
  std::unique_ptr<Work> work_;
  std::deque<std::string> without_errors_;  // Paths of prepared datasets.

  // Guards what follows.
  mutable std::mutex mutex_;
  std::condition_variable progressed_;
  std::optional<DatasetReading> reading_;  // The latest; a catalogue omits it once it is served.
  std::optional<std::string> first_name_;  // The first prepared dataset.
  bool has_prepared_all_ = false;          // The samples of all volumes, as far as possible.
  bool has_news_ = false;                  // `changed_` was not called for them.
  std::function<void()> changed_, finished_;
  std::jthread thread_;  // Ends before what it uses.
};

}  // namespace multitetra
