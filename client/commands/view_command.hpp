// `multitetra-client view`: the address of the browser viewer that shows a surface.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/base/result.hpp"
#include "common/cli/command.hpp"
#include "common/request/surface_query.hpp"

namespace multitetra {

struct ViewArguments {
  // The address of the server's HTTP listener; empty: derived from `server`.
  std::string http = {};
  // The server, as other commands name it.
  std::string server = {};
  std::string dataset = {};  // Empty: the first that is served.
  SurfaceQuery query = {};
  // Its fields that were given, by name and as the viewer reads them.
  std::vector<std::pair<std::string, std::string>> fields = {};
  std::string up = "z";      // The axis that is above, or with a minus its opposite.
  std::string clip = "off";  // Or the axis along which the surface is cut open.
};

void add_view(Command& app, ViewArguments& arguments);

// What client/web/src/state/url_state.ts reads. kInvalidArgument where the server's address has no
// viewer.
[[nodiscard]] Result<std::string> viewer_address(const ViewArguments& arguments);

// Gives the exit code.
int view(const ViewArguments& arguments);

}  // namespace multitetra
