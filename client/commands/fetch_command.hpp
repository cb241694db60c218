// `multitetra-client fetch`: fetches an isosurface, checks it and writes a mesh file.
#pragma once

#include <string>

#include "client/commands/connected_request.hpp"
#include "common/cli/command.hpp"
#include "common/cli/surface_output.hpp"

namespace multitetra {

struct FetchArguments {
  SurfaceOrder order;
  bool previews = false;
  int retries = 5;
  std::string resume_directory;
  std::string steps_directory;
  OutputArguments output;
};

void add_fetch(Command& app, FetchArguments& arguments);

// Returns the exit code.
[[nodiscard]] int fetch(const FetchArguments& arguments);

}  // namespace multitetra
