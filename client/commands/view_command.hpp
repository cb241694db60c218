// `multitetra-client view`: the address of the browser viewer that shows a surface.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/base/result.hpp"
#include "common/cli/command.hpp"

namespace multitetra {

struct ViewArguments {
  std::string http = {};           // Where the server's HTTP listener is; empty: as
  std::string server = {};         // this says, where other commands find the server.
  std::string dataset = {};        // Empty: the first that is served.
  std::optional<double> isovalue;  // None: the dataset's first suggestion.
  double error = 0.25;             // Voxels.
  std::string bound = "certified";
  std::string topology_rule = "exact";
  double topology_tolerance = 0;
  std::uint64_t max_triangles = 0;  // 0: no limit.
  std::string simplify = "on";
  std::string clip = "off";  // Or the axis along which the surface is cut open.
  double min_component = 0;  // Samples; components with a shorter diagonal are hidden.
  std::string region = {};   // As parse_region reads it, a box or a ball; empty: none.
};

void add_view(Command& app, ViewArguments& arguments);

// What client/web/src/state/url_state.ts reads back; defaults are left out. kInvalidArgument when
// the viewer could not.
[[nodiscard]] Result<std::string> viewer_address(const ViewArguments& arguments);

// Gives the exit code.
int view(const ViewArguments& arguments);

}  // namespace multitetra
