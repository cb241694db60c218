#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/exit_codes.hpp"
#include "common/base/in_parallel.hpp"
#include "common/base/percent_encoded.hpp"
#include "common/cli/terminal.hpp"
#include "server/operations/access_list.hpp"
#include "server/programs/commands.hpp"
#include "server/programs/serving/dataset_server.hpp"
#include "server/programs/thread_options.hpp"
#include "server/programs/view/viewed_volumes.hpp"
#include "server/programs/view/volume_queue.hpp"
#include "server/routes/one_time_link.hpp"

namespace multitetra {
namespace {

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

// Returns the program that opens addresses; empty without a graphical session.
std::string opener() {
  if (const std::string own = variable("BROWSER"); !own.empty()) {
    return own.substr(0, own.find(':'));  // The first of a list.
  }
#ifdef __APPLE__
  return "open";
#else
  const bool has_session = !variable("DISPLAY").empty() || !variable("WAYLAND_DISPLAY").empty();
  return has_session ? "xdg-open" : "";
#endif
}

// Opens an address with $BROWSER, else with `open` (macOS) or, in a graphical session, `xdg-open`.
// Returns false if there is no session or program; does not detect whether the page loads.
bool open_in_browser(const std::string& address) {
  std::string program = opener();
  if (program.empty()) return false;
  std::string argument = address;
  std::array<char*, 3> words = {program.data(), argument.data(), nullptr};
  // A new session, so Ctrl-C in this terminal does not end the browser.
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_t actions;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  posix_spawn_file_actions_init(&actions);
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&actions, descriptor, "/dev/null", O_RDWR, 0);
  }
  pid_t id = 0;
  const int error =
      ::posix_spawnp(&id, program.c_str(), &actions, &attributes, words.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  return error == 0;
}

struct ViewArguments {
  std::vector<std::string> inputs;
  VolumeQueueOptions volumes;
  std::string up = "z";
  std::string http = "http://127.0.0.1:0";
  bool no_browser = false;
  int threads = 0;
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

// The fragment of the page's address.
std::string page_fragment(const ViewArguments& arguments, const std::string& token,
                          const std::optional<std::string>& first) {
  std::string fragment = "#token=" + token;
  if (first) fragment += "&dataset=" + percent_encoded(*first);
  if (arguments.inputs.empty()) fragment += kDemoLook;
  if (!arguments.volumes.labels.empty() && first && !is_prepared(arguments.volumes.labels)) {
    fragment += "&labels=" + percent_encoded(default_dataset_name(arguments.volumes.labels)) +
                ":&opacity=0.35";
  }
  if (arguments.up != "z") fragment += "&up=" + arguments.up;
  return fragment;
}

int view(const ViewArguments& arguments) {
  const ThreadLimit limit(arguments.threads);
  std::vector<std::string> inputs = arguments.inputs;
  if (inputs.empty() && !arguments.volumes.labels.empty()) {
    throw ExitError(kUsage,
                    "--labels needs the volume that they belong to. For labels alone: "
                    "multitetra-server prepare " +
                        arguments.volumes.labels +
                        " --label all -o labels/, then multitetra view labels/.");
  }
  if (inputs.empty()) inputs.push_back(demo_volume().string());
  std::optional<VolumeQueue> made;
  try {
    (void)outside_from(arguments.volumes.outside.empty() ? "void" : arguments.volumes.outside);
    made.emplace(inputs, arguments.volumes);
  } catch (const VolumeFileError& problem) {
    throw ExitError(kUsage, problem.what());
  }
  VolumeQueue& volumes = *made;
  ServeOptions options;
  if (volumes.begin()) options.readings = volumes.readings();
  options.listeners.tcp = "off";
  options.listeners.http = arguments.http;
  // The token keeps other users of this machine out, who can find the port.
  options.listeners.token = new_token();
  const std::string fragment = page_fragment(arguments, options.listeners.token, volumes.first());
  const auto opening = std::make_shared<OneTimeLink>(new_token(), fragment);
  options.listeners.routes.opening = opening;
  options.listeners.log_level = "warning";
  options.listeners.drain_seconds = 1;
  options.listeners.ends_on_hangup = true;
  options.threads = arguments.threads;
  options.datasets = volumes.datasets();
  return serve_until_stopped(options, [&](const OpenServer& server) {
    const std::string address = local(server.urls.front());
    std::cout << "\n   " << styled(Style::kBold, address + "/" + fragment, STDOUT_FILENO) << "\n\n"
              << "   Serving until Ctrl-C." << std::endl;
    // Other users can read the words that a browser is started with.
    if (!arguments.no_browser) {
      open_in_browser(address + std::string(kOpenPath) + opening->code());
    }
    return volumes.run_behind(server.read_again, server.stop_if_empty);
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
      ->add_option("--labels", a->volumes.labels,
                   "Label map, or labels prepared from one, shown with the volume; offered by "
                   "default: those of an OME-Zarr, or one named like the volume: ct_seg.nii.gz")
      ->type_name("FILE|FOLDER");
  command
      ->add_option("--label-names", a->volumes.label_names,
                   "Names and colors of the labels; a file from ITK-SNAP or 3D Slicer")
      ->type_name("FILE");
  command->add_flag("--no-labels", a->volumes.no_labels, "Do not show label maps as labels");
  add_border_options(*command, a->volumes.outside, a->volumes.margin);
  command->add_option("--up", a->up, "World axis that points up initially, such as -y")
      ->one_of({"x", "-x", "y", "-y", "z", "-z"})
      ->capture_default_str();
  command->add_option("--http", a->http, "Address to listen on; port 0: any free port")
      ->envname("MULTITETRA_HTTP")
      ->capture_default_str();
  command->add_flag("--no-browser", a->no_browser, "Only print the address");
  command->add_flag("--no-cache", a->volumes.no_cache, "Prepare again, ignoring the cache");
  command->add_flag("--quiet", a->volumes.quiet, "Print only the address and errors");
  add_threads_option(*command, a->threads);
  command->begin_group("Cache");
  command->add_option("--cache-dir", a->volumes.cache_folder,
                      "Folder of the cached datasets, new or empty at first (default: multitetra "
                      "in $XDG_CACHE_HOME or "
                      "~/.cache)");
  command
      ->add_option("--cache-dir-bytes", a->volumes.cache_bytes,
                   "Size limit of that folder; the least recently used datasets are evicted first")
      ->as_bytes()
      ->capture_default_str();
  command->begin_group("Reading the volume");
  a->volumes.volume.add_to(*command);
  a->volumes.volume.add_space_to(*command);
  command->footer(
      "Examples:\n"
      "  multitetra view\n"
      "  multitetra view head.nii.gz\n"
      "  multitetra view dicom_folder/ --series 2\n"
      "  multitetra view flow_*.vti\n"
      "  multitetra view ct.nii.gz --pad-value -1024 --pad 1\n"
      "  multitetra view ct.nii.gz --labels organs.seg.nrrd\n"
      "  multitetra view https://example.org/image.zarr --channel 0");
  command->callback([a, &run] { run = [a] { return view(*a); }; });
}

}  // namespace multitetra
