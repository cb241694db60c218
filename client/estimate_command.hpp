// `multitetra-client estimate`: how large a mesh would be, before it is fetched.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "common/endpoint.hpp"
#include "common/surface_options.hpp"

namespace multitetra {

struct EstimateArguments {
  std::string server = to_string(Endpoint{.host = "127.0.0.1"});
  std::string dataset;
  SurfaceArguments surface;
  bool json = false;
};

void add_estimate(CLI::App& app, EstimateArguments& arguments);

// Gives the exit code.
int estimate(const EstimateArguments& arguments);

}  // namespace multitetra
