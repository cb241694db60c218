// Runs a server of datasets with the listeners, limits and caches of its options.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/programs/serving/serve_options.hpp"

namespace multitetra {

// A server with open listeners.
struct OpenServer {
  // The listeners' addresses: first TCP, unless disabled, then HTTP.
  std::vector<std::string> urls;
  // Reloads the folders of datasets on a separate thread. Callable from any thread, until the
  // background task has ended.
  std::function<void()> read_again;
  // Does the same, after which an empty list of datasets ends the server: no further one is being
  // read.
  std::function<void()> stop_if_empty;
};

// Starts work in the background. Called once, before the first connection is accepted; the result,
// such as a std::shared_ptr<std::jthread>, is destroyed when the server has stopped.
using BackgroundTask = std::function<std::shared_ptr<void>(const OpenServer&)>;

// Serves until SIGINT or SIGTERM. Returns the exit code. Throws ExitError if there is no dataset to
// serve and none is being read, or the secrets cannot be used, AddressError if a listener cannot be
// opened.
int serve_until_stopped(const ServeOptions& options, const BackgroundTask& beside = {});

}  // namespace multitetra
