// `multitetra-client estimate`: how large a mesh would be, before it is fetched.
#pragma once

#include <CLI/CLI.hpp>

#include "client/ordered_surface.hpp"

namespace multitetra {

struct EstimateArguments {
  SurfaceOrder order;
  bool json = false;
};

void add_estimate(CLI::App& app, EstimateArguments& arguments);

// Gives the exit code.
[[nodiscard]] int estimate(const EstimateArguments& arguments);

}  // namespace multitetra
