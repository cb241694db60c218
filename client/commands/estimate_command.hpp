// `multitetra-client estimate`: how large a mesh would be, before it is fetched.
#pragma once

#include "client/commands/connected_request.hpp"
#include "common/cli/command.hpp"

namespace multitetra {

struct EstimateArguments {
  SurfaceOrder order;
  bool json = false;
};

void add_estimate(Command& app, EstimateArguments& arguments);

// Gives the exit code.
[[nodiscard]] int estimate(const EstimateArguments& arguments);

}  // namespace multitetra
