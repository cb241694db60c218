// A server of datasets at work, with the listeners, limits and caches that its options name.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/programs/serving/serve_options.hpp"

namespace multitetra {

// A server whose listeners are open.
struct OpenServer {
  // The listeners' addresses: TCP first if there is one, then HTTP.
  std::vector<std::string> urls;
  // Reads the folders of datasets again, on a thread of its own. From any thread, until the work
  // that was given this has returned.
  std::function<void()> read_again;
};

// Work beside the serving. It is called once, before the first connection is taken, and what it
// returns is destroyed when the server has stopped: a std::shared_ptr<std::jthread>, for example.
using BackgroundTask = std::function<std::shared_ptr<void>(const OpenServer&)>;

// Serves until SIGINT or SIGTERM. Returns the exit code. Throws ExitError when there is no dataset
// to serve or the secrets cannot be used, AddressError when a listener cannot be opened.
int serve_until_stopped(const ServeOptions& options, const BackgroundTask& beside = {});

}  // namespace multitetra
