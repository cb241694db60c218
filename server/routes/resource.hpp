// The resources of the HTTP interface. Each is a file of this folder with one function that returns
// its path and how it answers, and a line in resources().
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/http_options.hpp"
#include "server/http/http_response.hpp"
#include "server/http/request_context.hpp"
#include "server/http/target.hpp"
#include "server/routes/path_pattern.hpp"
#include "server/routes/route_options.hpp"
#include "server/transport/listener.hpp"

namespace multitetra {

// Valid until the coroutine that it was passed to has ended.
struct ResourceRequest {
  const HttpRequest& http;
  const Target& target;
  const PathValues& path;  // What the parameters of the resource's pattern stand for.
  RequestContext& context;
};

struct Resource {
  enum class Kind {
    kProbe,   // Needs no token; answered also above the limits of connections.
    kFree,    // Needs no token.
    kCached,  // Needs a token; costs almost nothing, so it is not rate-limited.
    kMade,    // Needs a token; rate-limited. The first value of the path is the dataset.
    // The same, and the path may begin with the token, for viewers that send no header.
    kMadeWithTokenInPath,
  };
  const char* name;  // One word for log and metrics.
  PathPattern path;
  Kind kind = Kind::kMade;
  // Does not throw for any client input.
  std::function<asio::awaitable<HttpResponse>(ResourceRequest request)> answer;
};

// What resources are made from. Outlives them.
struct ResourceContext {
  ServerContext server;
  HttpOptions http;
  RouteOptions options;
};

[[nodiscard]] Resource liveness_resource(const ResourceContext& context);
[[nodiscard]] Resource readiness_resource(const ResourceContext& context);
[[nodiscard]] Resource metrics_resource(const ResourceContext& context);
[[nodiscard]] Resource api_description_resource(const ResourceContext& context);
[[nodiscard]] Resource stream_resource(const ResourceContext& context);
[[nodiscard]] Resource dataset_list_resource(const ResourceContext& context);
[[nodiscard]] Resource dataset_resource(const ResourceContext& context);
[[nodiscard]] Resource isosurface_resource(const ResourceContext& context);
[[nodiscard]] Resource slice_resource(const ResourceContext& context);
[[nodiscard]] Resource probe_resource(const ResourceContext& context);
[[nodiscard]] Resource thumbnail_resource(const ResourceContext& context);
[[nodiscard]] Resource tile_resource(const ResourceContext& context);
[[nodiscard]] Resource tilesets_resource(const ResourceContext& context);
[[nodiscard]] Resource neuroglancer_resource(const ResourceContext& context);
[[nodiscard]] Resource opening_resource(const ResourceContext& context);
[[nodiscard]] Resource viewer_resource(const ResourceContext& context);  // All other paths.

}  // namespace multitetra
