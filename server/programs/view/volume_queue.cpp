#include "server/programs/view/volume_queue.hpp"

#include <chrono>
#include <filesystem>
#include <iostream>
#include <utility>

#include "common/base/exit_codes.hpp"
#include "common/base/in_parallel.hpp"
#include "common/base/number_text.hpp"
#include "common/base/scratch_file.hpp"
#include "common/cli/program.hpp"
#include "common/dataset/same_world.hpp"
#include "server/dataset/label_detection.hpp"
#include "server/dataset/prepared_file.hpp"
#include "server/programs/prepare/series_jobs.hpp"
#include "server/programs/view/viewed_volumes.hpp"

namespace multitetra {

namespace fs = std::filesystem;

// Provides folders for datasets: in the cache, or in a temporary folder that is removed at the end.
class VolumeQueue::Folders {
 public:
  explicit Folders(const VolumeQueueOptions& options) {
    fs::path folder = options.cache_folder;
    if (folder.empty() && !options.no_cache) folder = default_cache_folder();
    if (!folder.empty() && !options.no_cache) {
      try {
        cache_.emplace(folder, options.cache_bytes);
        return;
      } catch (const CacheFolderError& error) {
        if (!options.cache_folder.empty()) throw ExitError(kUsage, error.what());
        std::cerr << options.command << ": " << error.what()
                  << " The prepared datasets are temporary." << std::endl;
      }
    }
    temporary_.emplace();
  }

  std::string folder_for(const PrepareArguments& preparation) {
    if (cache_) return cache_->entry(cache_key(preparation)).string();
    const fs::path folder = temporary_->path() / std::to_string(count_++);
    fs::create_directory(folder);
    return folder.string();
  }
  void evict() {
    if (cache_) cache_->evict();
  }

 private:
  std::optional<DatasetCache> cache_;
  std::optional<ScratchFolder> temporary_;
  int count_ = 0;
};

// The preparation in progress.
struct VolumeQueue::Work {
  Work(const char* command, PrepareArguments& arguments, const std::stop_token& stop)
      : maps(arguments.output, arguments.label_ends(), stop), preparation(arguments, maps, stop) {
    const auto notice = [&](const std::string& text) {
      if (!arguments.quiet) std::cerr << command << ": " << text << std::endl;
    };
    for (PrepareJob& job : jobs_of(arguments, maps, notice)) jobs.push_back(std::move(job));
    if (jobs.size() > 1) arguments.quiet = true;  // One line for all: see prepare_next().
  }
  LatestLabelMap maps;
  Preparation preparation;
  std::deque<PrepareJob> jobs;
  std::size_t prepared = 0;
};

VolumeQueue::VolumeQueue(std::vector<std::string> inputs, VolumeQueueOptions options)
    : options_(std::move(options)), folders_(std::make_unique<Folders>(options_)) {
  std::vector<std::string> volumes;
  for (std::string& input : inputs) (is_prepared(input) ? datasets_ : volumes).push_back(input);
  if (!volumes.empty()) {
    for (PrepareArguments& one : preparations_of(volumes, options_.volume)) {
      one.outside = options_.outside;
      one.margin = options_.margin;
      add(std::move(one));
    }
  }
  std::vector<std::string> label_maps;
  if (!options_.labels.empty()) {
    if (!is_address(options_.labels) && !fs::exists(options_.labels)) {
      throw ExitError(kUsage, "--labels: '" + options_.labels + "' does not exist.");
    }
    (is_prepared(options_.labels) ? datasets_ : label_maps).push_back(options_.labels);
  } else if (!options_.no_labels && volumes.size() == 1 && !is_address(volumes.front())) {
    label_maps = label_maps_of(volumes.front());
  }
  for (const std::string& map : label_maps) {
    print_line("The labels of '" + map + "' appear when they are ready.");
    PrepareArguments labels = preparation_of_labels(map);
    labels.volume.resample = options_.volume.resample;
    labels.series.label_names = options_.label_names;
    add(std::move(labels));
  }
}

VolumeQueue::~VolumeQueue() = default;

std::optional<std::string> VolumeQueue::prepare_next(const std::stop_token& stop) {
  for (; !waiting_.empty(); waiting_.pop_front()) {
    PrepareArguments& arguments = waiting_.front();
    try {
      if (!work_) work_ = std::make_unique<Work>(options_.command, arguments, stop);
      while (!work_->jobs.empty()) {
        const PrepareJob job = std::move(work_->jobs.front());
        work_->jobs.pop_front();
        if (!prepare(job)) continue;
        ++work_->prepared;
        return job.name;
      }
      if (work_->prepared > 1) {
        print_line("The " + std::to_string(work_->prepared) + " datasets of '" +
                   arguments.inputs.front() + "' are ready.");
      }
    } catch (const PreparationStopped&) {
      throw;
    } catch (const std::exception& problem) {
      print_error("multitetra", problem.what());
    }
    work_.reset();
  }
  folders_->evict();
  return std::nullopt;
}

bool VolumeQueue::complete_next(const std::stop_token& stop) {
  for (; !without_errors_.empty(); without_errors_.pop_front()) {
    const std::string& file = without_errors_.front();
    try {
      PrepareArguments arguments;
      arguments.quiet = true;
      LatestLabelMap unused({}, LabelEnds::kOpen);
      DatasetOutput output(file, /*force=*/false);
      const DatasetInfo info =
          Preparation(arguments, unused, stop).complete_one(file, output, in_idle_time).info;
      fs::permissions(file, fs::perms{kCachedFileMode});
      print_line("The errors of '" + info.name + "' are computed.");
      without_errors_.pop_front();
      return true;
    } catch (const PreparationStopped&) {
      throw;
    } catch (const std::exception& problem) {
      print_error("multitetra", problem.what());
    }
  }
  folders_->evict();
  return false;
}

void VolumeQueue::run(const std::stop_token& stop) {
  const auto report = [this](auto&& change) {
    const std::lock_guard lock(mutex_);
    change();
    progressed_.notify_all();
    if (changed_) {
      changed_();
    } else {
      has_news_ = true;
    }
  };
  try {
    while (const std::optional<std::string> name = prepare_next(stop)) {
      report([&] {
        if (!first_name_) first_name_ = name;
      });
    }
    report([&] {
      has_prepared_all_ = true;
      reading_.reset();
      if (finished_) finished_();
    });
    while (complete_next(stop)) report([] {});
  } catch (const PreparationStopped&) {  // The server has stopped.
  }
}

bool VolumeQueue::begin() {
  constexpr std::chrono::milliseconds kPatience(300);
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  std::unique_lock lock(mutex_);
  progressed_.wait_for(lock, kPatience, [this] { return first_name_ || has_prepared_all_; });
  return first_name_ || !has_prepared_all_;
}

std::optional<std::string> VolumeQueue::first() const {
  const std::lock_guard lock(mutex_);
  if (first_name_ || !reading_) return first_name_;
  return reading_->name;
}

ReadingsSource VolumeQueue::readings() const {
  return [this]() -> std::vector<DatasetReading> {
    const std::lock_guard lock(mutex_);
    if (!reading_) return {};
    return {*reading_};
  };
}

std::shared_ptr<void> VolumeQueue::run_behind(std::function<void()> changed,
                                              std::function<void()> finished) {
  const std::lock_guard lock(mutex_);
  changed_ = std::move(changed);
  finished_ = std::move(finished);
  if (has_news_) changed_();
  if (has_prepared_all_) finished_();
  return {this, [](VolumeQueue* queue) {
            queue->thread_.request_stop();
            queue->thread_.join();
          }};
}

void VolumeQueue::print_line(const std::string& text) const {
  if (!options_.quiet) std::cerr << options_.command << ": " << text << std::endl;
}

void VolumeQueue::add(PrepareArguments arguments) {
  arguments.output = folders_->folder_for(arguments);
  datasets_.push_back(arguments.output);
  wait_for(std::move(arguments));
}

// Adds labels found while serving, in a subfolder of a folder that is served.
void VolumeQueue::add_labels_of(const std::string& input) {
  print_line("'" + input +
             "' looks like labels; their surfaces appear in the list when they are ready "
             "(--no-labels ignores them).");
  PrepareArguments arguments = preparation_of_labels(input);
  arguments.volume = waiting_.front().volume;
  arguments.series.label_names = options_.label_names;
  const fs::path folder = fs::path(waiting_.front().output) / "labels";
  fs::create_directories(folder);
  arguments.output = folder.string();
  wait_for(std::move(arguments));
}

void VolumeQueue::wait_for(PrepareArguments arguments) {
  arguments.quiet = options_.quiet;
  arguments.samples_only = true;
  arguments.reading = [this](const std::string& dataset, double share) {
    const std::lock_guard lock(mutex_);
    reading_ = {dataset, share};
  };
  waiting_.push_back(std::move(arguments));
}

// Returns false if the dataset could not be prepared.
bool VolumeQueue::prepare(const PrepareJob& job) {
  try {
    waiting_.front().reading(job.name, 0);
    (void)work_->preparation.prepare_unless_up_to_date(job);
    fs::permissions(job.output, fs::perms{kCachedFileMode});
    const PreparedFile prepared(job.output.string());
    if (!prepared.info().missing.empty()) without_errors_.push_back(job.output.string());
    if (!first_) first_ = prepared.info();
    if (job.member && job.member->label && work_->prepared == 0)
      report_other_grid(job.input, prepared.info());
    const bool has_labels = looks_like_labels(prepared.info(), *prepared.samples());
    if (has_labels && !options_.no_labels) add_labels_of(job.input);
    return true;
  } catch (const PreparationStopped&) {
    throw;
  } catch (const std::exception& problem) {
    print_error("multitetra", problem.what());
    const std::lock_guard lock(mutex_);
    reading_.reset();
    return false;
  }
}

// Prints how the grid of labels differs from that of the volume.
void VolumeQueue::report_other_grid(const std::string& input, const DatasetInfo& labels) const {
  const std::string mismatch = world_mismatch(*first_, labels);
  if (!mismatch.empty()) {
    print_line("The labels of '" + input + "' do not belong to '" + first_->name +
               "': " + mismatch);
  } else if (labels.dims != first_->dims || labels.index_to_world != first_->index_to_world) {
    const std::string sizes = labels.dims == first_->dims
                                  ? ", of the same size,"
                                  : " (" + sides_text(labels.dims) + " samples)";
    print_line("The labels of '" + input + "' are on another grid" + sizes + " than '" +
               first_->name + "' (" + sides_text(first_->dims) +
               "): they appear where their header places them.");
  }
}

}  // namespace multitetra
