#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "common/base/number_text.hpp"
#include "common/base/percent_encoded.hpp"
#include "common/cli/program.hpp"
#include "common/cli/terminal.hpp"
#include "common/dataset/same_world.hpp"
#include "server/dataset/label_detection.hpp"
#include "server/dataset/prepared_file.hpp"
#include "server/operations/access_list.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/prepare/detail/preparation.hpp"
#include "server/programs/prepare/series_jobs.hpp"
#include "server/programs/serving/dataset_server.hpp"
#include "server/programs/thread_options.hpp"
#include "server/programs/view/browser.hpp"
#include "server/programs/view/dataset_cache.hpp"
#include "server/programs/view/viewed_volumes.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

struct ViewArguments {
  std::vector<std::string> inputs;
  VolumeOptions volume;
  std::string outside;        // Empty: void.
  std::optional<int> margin;  // None: 0.
  std::string labels;
  std::string label_names;
  bool no_labels = false;
  std::string up = "z";
  std::string http = "http://127.0.0.1:0";
  std::string cache_folder;
  std::uint64_t cache_bytes = std::uint64_t{20} << 30;
  bool no_cache = false;
  bool no_browser = false;
  bool quiet = false;
  int threads = 0;
};

// Provides folders for datasets: in the cache, or in a temporary folder that is removed at the end.
class DatasetFolders {
 public:
  explicit DatasetFolders(const ViewArguments& arguments) {
    fs::path folder = arguments.cache_folder;
    if (folder.empty() && !arguments.no_cache) folder = default_cache_folder();
    if (!folder.empty() && !arguments.no_cache) {
      try {
        cache_.emplace(folder, arguments.cache_bytes);
        return;
      } catch (const CacheFolderError& error) {
        if (!arguments.cache_folder.empty()) throw ExitError(kUsage, error.what());
        std::cerr << "view: " << error.what() << " The prepared datasets are temporary."
                  << std::endl;
      }
    }
    std::string name = (fs::temp_directory_path() / "multitetra-view.XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      throw std::system_error(errno, std::generic_category(), "Cannot create " + name);
    }
    temporary_ = name;
  }
  ~DatasetFolders() {
    std::error_code ignored;
    if (!temporary_.empty()) fs::remove_all(temporary_, ignored);
  }
  DatasetFolders(const DatasetFolders&) = delete;
  DatasetFolders& operator=(const DatasetFolders&) = delete;

  std::string folder_for(const PrepareArguments& preparation) {
    if (cache_) return cache_->entry(cache_key(preparation)).string();
    const fs::path folder = temporary_ / std::to_string(count_++);
    fs::create_directory(folder);
    return folder.string();
  }
  void evict() {
    if (cache_) cache_->evict();
  }

 private:
  std::optional<DatasetCache> cache_;
  fs::path temporary_;
  int count_ = 0;
};

// All volumes to show, in the order of preparation. Not thread-safe.
class ViewedVolumes {
 public:
  ViewedVolumes(const ViewArguments& arguments, std::vector<std::string> inputs)
      : arguments_(arguments), folders_(arguments) {
    std::vector<std::string> volumes;
    for (std::string& input : inputs) (is_prepared(input) ? datasets_ : volumes).push_back(input);
    has_datasets_ = !datasets_.empty();
    if (!volumes.empty()) {
      for (PrepareArguments& one : preparations_of(volumes, arguments.volume)) {
        one.outside = arguments.outside;
        one.margin = arguments.margin;
        add(std::move(one));
      }
    }
    std::vector<std::string> label_maps;
    if (!arguments.labels.empty()) {
      if (!is_address(arguments.labels) && !fs::exists(arguments.labels)) {
        throw ExitError(kUsage, "--labels: '" + arguments.labels + "' does not exist.");
      }
      (is_prepared(arguments.labels) ? datasets_ : label_maps).push_back(arguments.labels);
    } else if (!arguments.no_labels && volumes.size() == 1 && !is_address(volumes.front())) {
      label_maps = label_maps_of(volumes.front());
    }
    for (const std::string& map : label_maps) {
      print_line("The labels of '" + map + "' appear when they are ready.");
      PrepareArguments labels = preparation_of_labels(map);
      labels.volume.resample = arguments.volume.resample;
      labels.series.label_names = arguments.label_names;
      add(std::move(labels));
    }
  }

  // Returns whether any input was already a dataset.
  [[nodiscard]] bool has_datasets() const { return has_datasets_; }

  // Returns the paths of the datasets, including those not yet prepared.
  [[nodiscard]] const std::vector<std::string>& datasets() const { return datasets_; }

  // Prepares volumes until one succeeds. Returns its name, or none at the end. Prints failures to
  // stderr. Throws PreparationStopped.
  std::optional<std::string> prepare_next(const std::stop_token& stop) {
    for (; !waiting_.empty(); waiting_.pop_front()) {
      PrepareArguments& arguments = waiting_.front();
      try {
        if (!work_) work_ = std::make_unique<Work>(arguments, stop);
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
    folders_.evict();
    return std::nullopt;
  }

 private:
  // The preparation in progress.
  struct Work {
    Work(PrepareArguments& arguments, const std::stop_token& stop)
        : maps(arguments.output), preparation(arguments, maps, stop) {
      const auto notice = [&](const std::string& text) {
        if (!arguments.quiet) std::cerr << "view: " << text << std::endl;
      };
      for (PrepareJob& job : jobs_of(arguments, maps, notice)) jobs.push_back(std::move(job));
      if (jobs.size() > 1) arguments.quiet = true;  // One line for all: see prepare_next().
    }
    LatestLabelMap maps;
    Preparation preparation;
    std::deque<PrepareJob> jobs;
    std::size_t prepared = 0;
  };

  void print_line(const std::string& text) const {
    if (!arguments_.quiet) std::cerr << "view: " << text << std::endl;
  }

  void add(PrepareArguments arguments) {
    arguments.output = folders_.folder_for(arguments);
    datasets_.push_back(arguments.output);
    wait_for(std::move(arguments));
  }

  // Adds labels found while serving, in a subfolder of a folder that is served.
  void add_labels_of(const std::string& input) {
    print_line("'" + input +
               "' looks like labels; their surfaces appear in the list when they are ready "
               "(--no-labels ignores them).");
    PrepareArguments arguments = preparation_of_labels(input);
    arguments.volume = waiting_.front().volume;
    arguments.series.label_names = arguments_.label_names;
    const fs::path folder = fs::path(waiting_.front().output) / "labels";
    fs::create_directories(folder);
    arguments.output = folder.string();
    wait_for(std::move(arguments));
  }

  void wait_for(PrepareArguments arguments) {
    arguments.quiet = arguments_.quiet;
    waiting_.push_back(std::move(arguments));
  }

  // Returns false if the dataset could not be prepared.
  bool prepare(const PrepareJob& job) {
    try {
      (void)work_->preparation.prepare_unless_up_to_date(job);
      fs::permissions(job.output, fs::perms{kCachedFileMode});
      const PreparedFile prepared(job.output.string());
      if (!first_) first_ = prepared.info();
      if (job.member && job.member->label && work_->prepared == 0)
        report_other_grid(job.input, prepared.info());
      const bool has_labels = looks_like_labels(prepared.info(), *prepared.samples());
      if (has_labels && !arguments_.no_labels) add_labels_of(job.input);
      return true;
    } catch (const PreparationStopped&) {
      throw;
    } catch (const std::exception& problem) {
      print_error("multitetra", problem.what());
      return false;
    }
  }

  // Prints how the grid of labels differs from that of the volume.
  void report_other_grid(const std::string& input, const DatasetInfo& labels) const {
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

  const ViewArguments& arguments_;
  std::optional<DatasetInfo> first_;  // The first one prepared.
  DatasetFolders folders_;
  std::vector<std::string> datasets_;
  bool has_datasets_ = false;
  // The first one is in progress.
  std::deque<PrepareArguments> waiting_;
  std::unique_ptr<Work> work_;
};

// Returns an address that works on this machine, even for a listener on all interfaces.
std::string local(std::string url) {
  for (const std::string all : {"//0.0.0.0:", "//[::]:"}) {
    if (const std::size_t at = url.find(all); at != std::string::npos) {
      url.replace(at, all.size(), "//localhost:");
    }
  }
  return url;
}

void show(const std::string& address, const ViewArguments& arguments) {
  std::cout << "\n   " << styled(Style::kBold, address, STDOUT_FILENO) << "\n\n"
            << "   Serving until Ctrl-C." << std::endl;
  if (!arguments.no_browser) open_in_browser(address);
}

int view(const ViewArguments& arguments) {
  const ThreadLimit limit(arguments.threads);
  std::vector<std::string> inputs = arguments.inputs;
  if (inputs.empty() && !arguments.labels.empty()) {
    throw ExitError(kUsage,
                    "--labels needs the volume that they belong to. For labels alone: "
                    "multitetra-server prepare " +
                        arguments.labels +
                        " --label all -o labels/, then multitetra view labels/.");
  }
  if (inputs.empty()) inputs.push_back(demo_volume().string());
  std::optional<ViewedVolumes> made;
  try {
    (void)outside_from(arguments.outside.empty() ? "void" : arguments.outside);
    made.emplace(arguments, inputs);
  } catch (const VolumeFileError& problem) {
    throw ExitError(kUsage, problem.what());
  }
  ViewedVolumes& volumes = *made;
  const std::optional<std::string> first = volumes.prepare_next({});
  if (!first && !volumes.has_datasets()) return kUsage;  // Every problem was printed.
  ServeOptions options;
  options.listeners.tcp = "off";
  options.listeners.http = arguments.http;
  options.listeners.token = new_token();
  options.listeners.log_level = "warning";
  options.listeners.drain_seconds = 1;
  options.listeners.ends_on_hangup = true;
  options.threads = arguments.threads;
  options.datasets = volumes.datasets();
  return serve_until_stopped(options, [&](const OpenServer& server) {
    // The token keeps other users of this machine out, who can find the port.
    std::string shown = "#token=" + options.listeners.token;
    if (first) shown += "&dataset=" + percent_encoded(*first);
    if (arguments.inputs.empty()) shown += kDemoLook;
    if (!arguments.labels.empty() && first && !is_prepared(arguments.labels)) {
      shown +=
          "&labels=" + percent_encoded(default_dataset_name(arguments.labels)) + ":&opacity=0.35";
    }
    if (arguments.up != "z") shown += "&up=" + arguments.up;
    show(local(server.urls.front()) + "/" + shown, arguments);
    const auto rest = [&volumes, read_again = server.read_again](const std::stop_token& stop) {
      try {
        while (volumes.prepare_next(stop)) read_again();
      } catch (const PreparationStopped&) {  // The server has stopped.
      }
    };
    return std::make_shared<std::jthread>(rest);
  });
}

}  // namespace

void add_view_command(Command& program, Run& run) {
  const auto a = std::make_shared<ViewArguments>();
  Command* command = program.add_subcommand(
      "view", "Show a volume in the browser: prepares it, serves it on this machine, opens it");
  command
      ->add_option("input", a->inputs,
                   "Volumes or datasets: a file, a folder, an address; or files of a time series, "
                   "whose times `prepare --times` can set (default: a demo volume)")
      ->type_name("SOURCE");
  command
      ->add_option("--labels", a->labels,
                   "Label map, or labels prepared from one, shown with the volume; offered by "
                   "default: those of an OME-Zarr, or one named like the volume: ct_seg.nii.gz")
      ->type_name("FILE|FOLDER");
  command
      ->add_option("--label-names", a->label_names,
                   "Names and colors of the labels; a file from ITK-SNAP or 3D Slicer")
      ->type_name("FILE");
  command->add_flag("--no-labels", a->no_labels, "Do not show label maps as labels");
  add_border_options(*command, a->outside, a->margin);
  command->add_option("--up", a->up, "World axis that points up initially, such as -y")
      ->one_of({"x", "-x", "y", "-y", "z", "-z"})
      ->capture_default_str();
  command->add_option("--http", a->http, "Address to listen on; port 0: any free port")
      ->envname("MULTITETRA_HTTP")
      ->capture_default_str();
  command->add_flag("--no-browser", a->no_browser, "Only print the address");
  command->add_flag("--no-cache", a->no_cache, "Prepare again, ignoring the cache");
  command->add_flag("--quiet", a->quiet, "Print only the address and errors");
  add_threads_option(*command, a->threads);
  command->begin_group("Cache");
  command->add_option("--cache-dir", a->cache_folder,
                      "Folder of the cached datasets, new or empty at first (default: multitetra "
                      "in $XDG_CACHE_HOME or "
                      "~/.cache)");
  command
      ->add_option("--cache-dir-bytes", a->cache_bytes,
                   "Size limit of that folder; the least recently used datasets are evicted first")
      ->as_bytes()
      ->capture_default_str();
  command->begin_group("Reading the volume");
  a->volume.add_to(*command);
  a->volume.add_space_to(*command);
  command->footer(
      "Examples:\n"
      "  multitetra view\n"
      "  multitetra view head.nii.gz\n"
      "  multitetra view dicom_folder/ --series 2\n"
      "  multitetra view flow_*.vti\n"
      "  multitetra view ct.nii.gz --outside -1024 --margin 1\n"
      "  multitetra view ct.nii.gz --labels organs.seg.nrrd\n"
      "  multitetra view https://example.org/image.zarr --channel 0");
  command->callback([a, &run] { run = [a] { return view(*a); }; });
}

}  // namespace multitetra
