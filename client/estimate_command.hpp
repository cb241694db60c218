// `multitetra-client estimate`: how large a mesh would be, before it is fetched.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "client/server_options.hpp"
#include "common/surface_options.hpp"

namespace multitetra {

struct EstimateArguments {
  ServerArguments server;
  std::string dataset;
  SurfaceArguments surface;
  bool json = false;
};

void add_estimate(CLI::App& app, EstimateArguments& arguments);

// Gives the exit code.
int estimate(const EstimateArguments& arguments);

}  // namespace multitetra
