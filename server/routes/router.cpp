#include "server/routes/router.hpp"

#include <utility>

#include "server/http/host.hpp"
#include "server/http/http_listener.hpp"
#include "server/http/origin.hpp"
#include "server/http/upgrade.hpp"
#include "server/routes/datasets.hpp"
#include "server/routes/operations.hpp"
#include "server/routes/tile.hpp"
#include "server/routes/viewer.hpp"

namespace multitetra {
namespace {

constexpr std::string_view kMethods = "GET, HEAD, OPTIONS";

std::string_view bearer_token(const HttpRequest& request) {
  constexpr std::string_view kScheme = "Bearer ";
  const std::string_view credentials = field(request, http::field::authorization);
  if (credentials.size() < kScheme.size() ||
      !boost::beast::iequals({credentials.data(), kScheme.size()},
                             {kScheme.data(), kScheme.size()}))
    return {};
  return credentials.substr(kScheme.size());
}

// Returns the token in the path (for viewers that send no header) or in the header.
std::string token_of(const Route& route, const HttpRequest& request) {
  std::string token;
  if (const auto* tileset = std::get_if<TilesetFile>(&route)) token = tileset->token;
  if (const auto* file = std::get_if<NeuroglancerFile>(&route)) token = file->token;
  return token.empty() ? std::string(bearer_token(request)) : token;
}

std::string dataset_of(const Route& route) {
  return std::visit(
      [](const auto& r) -> std::string {
        if constexpr (requires { r.dataset; }) return r.dataset;
        return {};
      },
      route);
}

Answer methods_answer() {
  Answer answer{.status = 204};
  add_field(answer, "Allow", kMethods);
  return answer;
}

// Closes the service's caller at the end of a request, however it ends.
class ServedRequest {
 public:
  explicit ServedRequest(RequestContext& context) : context_(context) {}
  ~ServedRequest() {
    if (const CallerPtr caller = std::exchange(context_.caller, nullptr)) caller->close();
  }
  ServedRequest(const ServedRequest&) = delete;
  ServedRequest& operator=(const ServedRequest&) = delete;

 private:
  RequestContext& context_;
};

}  // namespace

Router::Router(const ServerContext& server, HttpOptions http, RouteOptions routes)
    : server_(server),
      http_(std::move(http)),
      routes_(std::move(routes)),
      isosurfaces_(routes_),
      tilesets_(routes_),
      neuroglancer_(routes_) {}

bool Router::is_probe(std::string_view text) const {
  const auto target = parse_target(without_base_path(without_authority(text), http_.base_path));
  const auto route = target ? route_of(*target) : Result<Route>(tl::unexpected(target.error()));
  return route &&
         (std::holds_alternative<Liveness>(*route) || std::holds_alternative<Readiness>(*route) ||
          std::holds_alternative<Metrics>(*route));
}

std::string Router::loggable(std::string_view target) const { return without_token(target); }

asio::awaitable<Outcome> Router::answer(const HttpRequest& request, RequestContext& context) {
  Outcome outcome = co_await routed(request, context);
  if (const auto* answer = std::get_if<Answer>(&outcome)) {
    auto reservation = context.client->reserve(memory_of(*answer));
    if (reservation) {
      context.reservation = *std::move(reservation);
    } else {
      outcome = context.refused(reservation.error());
    }
  }
  if (auto* answer = std::get_if<Answer>(&outcome)) {
    add_field(*answer, "X-Request-Id", context.request_id);
    add_field(*answer, "Cross-Origin-Resource-Policy",
              resource_policy(field(request, http::field::origin),
                              field(request, http::field::host), http_.allowed_origins));
    answer->fields +=
        cross_origin_fields(field(request, http::field::origin), field(request, http::field::host),
                            http_.allowed_origins, request.method() == http::verb::options);
  }
  co_return outcome;
}

asio::awaitable<Outcome> Router::routed(const HttpRequest& request, RequestContext& context) {
  const std::string_view host = field(request, http::field::host);
  if (!is_allowed_host(host, http_.allowed_hosts)) {
    co_return error_answer(
        421,
        {ErrorCode::kInvalidArgument,
         "Host \"" + std::string(host) +
             "\" is not allowed. Start the server with --allow-host to accept it."},
        context.request_id);
  }
  if (request.method() == http::verb::options && request.target() == "*") {
    co_return methods_answer();
  }
  const std::string_view path = without_authority(view_of(request.target()));
  if (is_base_path(path, http_.base_path)) {
    context.kind = "redirect";
    Answer answer{.status = 308};
    add_field(answer, "Location", http_.base_path + "/");
    co_return answer;
  }
  const auto target = parse_target(without_base_path(path, http_.base_path));
  const auto route = target ? route_of(*target) : Result<Route>(tl::unexpected(target.error()));
  if (!route) co_return error_answer(route.error(), context.request_id);
  context.kind = name(*route);
  if (request.method() == http::verb::options) {
    co_return methods_answer();
  }
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    Answer answer = error_answer(
        405,
        {ErrorCode::kInvalidArgument, "The method must be GET or HEAD, not " +
                                          std::string(view_of(request.method_string())) + "."},
        context.request_id);
    add_field(answer, "Allow", kMethods);
    co_return answer;
  }
  const std::string& id = context.request_id;
  if (std::holds_alternative<WebSocketStream>(*route)) {
    auto objection = upgrade_error(request, http_.allowed_origins, id);
    if (objection) co_return *std::move(objection);
    co_return UpgradeToWebSocket{};
  }
  if (const auto* file = std::get_if<ViewerFile>(&*route)) {
    co_return viewer_answer(*routes_.viewer, file->path, request, http_.allowed_origins, id);
  }
  if (std::holds_alternative<Liveness>(*route)) co_return liveness_answer();
  if (std::holds_alternative<Readiness>(*route)) co_return readiness_answer(server_, id);
  if (std::holds_alternative<Metrics>(*route)) co_return metrics_answer(server_, id);
  if (std::holds_alternative<Description>(*route)) co_return description_answer(request);
  if (is_from_other_site(view_of(request["Sec-Fetch-Site"]), field(request, http::field::origin),
                         host, http_.allowed_origins)) {
    co_return error_answer({ErrorCode::kPermissionDenied,
                            "Pages of other sites may use this server only with --allow-origin."},
                           id);
  }
  const RouteArguments arguments = {.request = request, .target = *target, .context = context};
  const ServedRequest under_way(context);
  co_return co_await served(*route, arguments);
}

asio::awaitable<Answer> Router::served(const Route& route, RouteArguments arguments) {
  RequestContext& context = arguments.context;
  // Cached tiles cost almost nothing, so they are not rate-limited.
  const bool is_counted = !std::holds_alternative<TileBytes>(route);
  const auto within_rate = [&] {
    return is_counted ? context.client->check_rate_limit() : Result<void>();
  };
  const std::string token = token_of(route, arguments.request);
  // Requests count for their token if the access list has it, else for their address.
  const AccessListPtr& access = context.client->admission().access();
  const auto permit = Permit::of(token, access, nullptr);
  const bool has_known_token = permit && permit->has_token();
  if (!has_known_token) {
    // Replaces the name set by the previous request.
    context.client->set_identity(access ? access->owner_of(token) : "", false);
    if (const auto allowed = within_rate(); !allowed) {
      co_return error_answer(429, allowed.error(), context.request_id);
    }
  }
  context.caller = server_.service.open(context.client);
  context.caller->set_request_id(context.number);
  const auto known = co_await context.caller->log_in(token);
  if (!known) co_return context.refused(known.error());
  if (has_known_token) {
    if (const auto allowed = within_rate(); !allowed) {
      co_return error_answer(429, allowed.error(), context.request_id);
    }
  }
  if (is_counted) {
    RequestFacts facts;
    facts.kind = context.kind;
    facts.id = context.request_id;
    facts.dataset = dataset_of(route);
    context.record = std::make_unique<RequestRecord>(context.client, std::move(facts));
  }
  co_return co_await answer_by(route, arguments);
}

asio::awaitable<Answer> Router::answer_by(const Route& route, RouteArguments arguments) {
  RequestContext& context = arguments.context;
  if (const auto* file = std::get_if<TilesetFile>(&route)) {
    co_return co_await tilesets_.answer(*file, arguments.request, context);
  }
  if (const auto* file = std::get_if<NeuroglancerFile>(&route)) {
    co_return co_await neuroglancer_.answer(*file, arguments.request, context);
  }
  if (const auto* surface = std::get_if<IsosurfaceResource>(&route)) {
    co_return co_await isosurfaces_.answer(surface->dataset, arguments.target, arguments.request,
                                           context);
  }
  if (const auto* slice = std::get_if<SliceOfSamples>(&route)) {
    co_return co_await samples_.slice(slice->dataset, arguments.target, arguments.request, context);
  }
  if (const auto* value = std::get_if<ValueAtPlaces>(&route)) {
    co_return co_await samples_.value(value->dataset, arguments.target, context);
  }
  if (const auto* picture = std::get_if<ThumbnailPicture>(&route)) {
    co_return co_await thumbnails_.answer(picture->dataset, arguments.target, arguments.request,
                                          context);
  }
  if (const auto* tile = std::get_if<TileBytes>(&route)) {
    co_return tile_answer(server_.service, tile->digest, arguments.request, context);
  }
  if (const auto* one = std::get_if<DatasetDescription>(&route)) {
    co_return dataset_answer(one->dataset, arguments.request, context);
  }
  co_return datasets_answer(arguments.request, context);
}

MakeListener http_listener(HttpOptions options, RouteOptions routes) {
  return [options = std::move(options),
          routes = std::move(routes)](const ServerContext& server) -> std::unique_ptr<Listener> {
    auto router = std::make_unique<Router>(server, options, routes);
    return std::make_unique<HttpListener>(server, options, std::move(router));
  };
}

}  // namespace multitetra
