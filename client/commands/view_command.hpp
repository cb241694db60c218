// `multitetra-client view`: prints the URL of the browser viewer for a surface.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/base/result.hpp"
#include "common/cli/command.hpp"
#include "common/request/surface_query.hpp"

namespace multitetra {

struct ViewArguments {
  // The URL of the server's HTTP listener; empty: derived from `server`.
  std::string http = {};
  // The server's address, as in other commands.
  std::string server = {};
  std::string dataset = {};  // Empty: the first one served.
  SurfaceQuery query = {};
  // The fields given by the user: name and value as the viewer reads them.
  std::vector<std::pair<std::string, std::string>> fields = {};
  std::string up = "z";      // The axis that points up: "x", "-z", ...
  std::string clip = "off";  // Or the axis along which the surface is clipped.
};

void add_view(Command& app, ViewArguments& arguments);

// Returns a URL for client/web/src/state/url_state.ts. Returns kInvalidArgument if the server's
// address has no viewer.
[[nodiscard]] Result<std::string> viewer_address(const ViewArguments& arguments);

// Returns the exit code.
int view(const ViewArguments& arguments);

}  // namespace multitetra
