// Dispatches each request to its route.
#pragma once

#include <string>
#include <string_view>

#include "server/http/http_options.hpp"
#include "server/http/request_handler.hpp"
#include "server/http/target.hpp"
#include "server/routes/isosurface.hpp"
#include "server/routes/neuroglancer.hpp"
#include "server/routes/route.hpp"
#include "server/routes/route_options.hpp"
#include "server/routes/samples.hpp"
#include "server/routes/thumbnail.hpp"
#include "server/routes/tilesets.hpp"
#include "server/transport/listener.hpp"

namespace multitetra {

class Router : public RequestHandler {
 public:
  // The objects that `server` refers to must outlive the router.
  Router(const ServerContext& server, HttpOptions http, RouteOptions routes);

  [[nodiscard]] asio::awaitable<Outcome> answer(const HttpRequest& request,
                                                RequestContext& context) override;
  [[nodiscard]] bool is_probe(std::string_view target) const override;
  [[nodiscard]] std::string loggable(std::string_view target) const override;

 private:
  // The arguments of a route.
  struct RouteArguments {
    const HttpRequest& request;
    const Target& target;
    RequestContext& context;
  };
  // Returns a route's answer, without the fields common to all answers.
  asio::awaitable<Outcome> routed(const HttpRequest& request, RequestContext& context);
  // Answers a request that uses the service, after checking its token.
  asio::awaitable<Answer> served(const Route& route, RouteArguments arguments);
  asio::awaitable<Answer> answer_by(const Route& route, RouteArguments arguments);

  const ServerContext server_;
  const HttpOptions http_;
  const RouteOptions routes_;
  IsosurfaceRoute isosurfaces_;
  SamplesRoute samples_;
  ThumbnailRoute thumbnails_;
  TilesetRoute tilesets_;
  NeuroglancerRoute neuroglancer_;
};

}  // namespace multitetra
