// `multitetra-client estimate`: estimates the size of a mesh before it is fetched.
#pragma once

#include "client/commands/connected_request.hpp"
#include "common/cli/command.hpp"

namespace multitetra {

struct EstimateArguments {
  SurfaceOrder order;
  bool json = false;
};

void add_estimate(Command& app, EstimateArguments& arguments);

// Returns the exit code.
[[nodiscard]] int estimate(const EstimateArguments& arguments);

}  // namespace multitetra
