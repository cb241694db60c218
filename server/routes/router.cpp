#include "server/routes/router.hpp"

#include <utility>

#include "server/http/host.hpp"
#include "server/http/http_listener.hpp"
#include "server/http/origin.hpp"

namespace multitetra {
namespace {

constexpr std::string_view kMethods = "GET, HEAD, OPTIONS";

// The first resource that matches a path has it.
std::vector<Resource> resources(const ResourceContext& context) {
  return {liveness_resource(context),  readiness_resource(context),
          metrics_resource(context),   api_description_resource(context),
          stream_resource(context),    dataset_list_resource(context),
          dataset_resource(context),   isosurface_resource(context),
          slice_resource(context),     probe_resource(context),
          thumbnail_resource(context), tile_resource(context),
          tilesets_resource(context),  neuroglancer_resource(context),
          opening_resource(context),   viewer_resource(context)};
}

std::string_view bearer_token(const HttpRequest& request) {
  constexpr std::string_view kScheme = "Bearer ";
  const std::string_view credentials = field(request, http::field::authorization);
  if (credentials.size() < kScheme.size() ||
      !boost::beast::iequals({credentials.data(), kScheme.size()},
                             {kScheme.data(), kScheme.size()}))
    return {};
  return credentials.substr(kScheme.size());
}

HttpResponse methods_answer() {
  HttpResponse response{.status = 204};
  add_field(response, "Allow", kMethods);
  return response;
}

// Closes the service's caller at the end of a request, however it ends.
class ServedRequest {
 public:
  explicit ServedRequest(RequestContext& context) : context_(context) {}
  ~ServedRequest() {
    if (const ServiceClientPtr service_client = std::exchange(context_.service_client, nullptr))
      service_client->close();
  }
  ServedRequest(const ServedRequest&) = delete;
  ServedRequest& operator=(const ServedRequest&) = delete;

 private:
  RequestContext& context_;
};

}  // namespace

Router::Router(ResourceContext context)
    : context_(std::move(context)), resources_(resources(context_)) {}

Router::Found Router::find(const Target& target) const {
  const auto tokened = path_with_token(target);
  for (const Resource& resource : resources_) {
    if (auto values = resource.path.match(target.path)) return {&resource, *std::move(values), {}};
    if (!tokened || resource.kind != Resource::Kind::kMadeWithTokenInPath) continue;
    if (auto values = resource.path.match(tokened->path)) {
      return {&resource, *std::move(values), tokened->token};
    }
  }
  return {&resources_.back(), {}, {}};
}

bool Router::is_probe(std::string_view text) const {
  const auto target =
      parse_target(without_base_path(without_authority(text), context_.http.base_path));
  return target && find(*target).resource->kind == Resource::Kind::kProbe;
}

std::string Router::loggable(std::string_view target) const { return without_token(target); }

asio::awaitable<HttpResponse> Router::answer(const HttpRequest& request, RequestContext& context) {
  HttpResponse response = co_await made(request, context);
  auto reservation = context.client->reserve(memory_of(response));
  if (reservation) {
    context.reservation = *std::move(reservation);
  } else {
    response = context.refused(reservation.error());
  }
  add_field(response, "X-Request-Id", context.request_id);
  add_field(response, "Cross-Origin-Resource-Policy",
            resource_policy(field(request, http::field::origin), field(request, http::field::host),
                            context_.http.allowed_origins));
  response.fields +=
      cross_origin_fields(field(request, http::field::origin), field(request, http::field::host),
                          context_.http.allowed_origins, request.method() == http::verb::options);
  co_return response;
}

asio::awaitable<HttpResponse> Router::made(const HttpRequest& request, RequestContext& context) {
  const auto refused = [&](int status, std::string text) {
    return error_answer(status, {ErrorCode::kInvalidArgument, std::move(text)}, context.request_id);
  };
  const std::string_view host = field(request, http::field::host);
  if (!is_allowed_host(host, context_.http.allowed_hosts)) {
    co_return refused(421, "Host \"" + std::string(host) +
                               "\" is not allowed. Start the server with --allow-host to accept "
                               "it.");
  }
  const bool is_options = request.method() == http::verb::options;
  if (is_options && request.target() == "*") co_return methods_answer();
  const std::string_view path = without_authority(view_of(request.target()));
  if (is_base_path(path, context_.http.base_path)) {
    context.kind = "redirect";
    HttpResponse response{.status = 308};
    add_field(response, "Location", context_.http.base_path + "/");
    co_return response;
  }
  const auto target = parse_target(without_base_path(path, context_.http.base_path));
  if (!target) co_return error_answer(target.error(), context.request_id);
  const Found found = find(*target);
  const Resource& resource = *found.resource;
  context.kind = resource.name;
  if (is_options) co_return methods_answer();
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    HttpResponse response = refused(405, "The method must be GET or HEAD, not " +
                                             std::string(view_of(request.method_string())) + ".");
    add_field(response, "Allow", kMethods);
    co_return response;
  }
  const ServedRequest under_way(context);
  if (resource.kind != Resource::Kind::kProbe && resource.kind != Resource::Kind::kFree) {
    if (is_from_other_site(view_of(request["Sec-Fetch-Site"]), field(request, http::field::origin),
                           host, context_.http.allowed_origins)) {
      co_return error_answer({ErrorCode::kPermissionDenied,
                              "Pages of other sites may use this server only with --allow-origin."},
                             context.request_id);
    }
    if (auto refusal = co_await admit(request, found, context)) co_return *std::move(refusal);
  }
  co_return co_await resource.answer(
      {.http = request, .target = *target, .path = found.values, .context = context});
}

asio::awaitable<std::optional<HttpResponse>> Router::admit(const HttpRequest& request,
                                                           const Found& found,
                                                           RequestContext& context) {
  const bool is_counted = found.resource->kind != Resource::Kind::kCached;
  const auto above_rate = [&]() -> std::optional<HttpResponse> {
    const auto within = is_counted ? context.client->check_rate_limit() : Result<void>();
    if (within) return std::nullopt;
    return error_answer(429, within.error(), context.request_id);
  };
  const std::string token = found.token.empty() ? std::string(bearer_token(request)) : found.token;
  // Requests count for their token if the access list has it, else for their address.
  const AccessListPtr& access = context.client->admission().access();
  const auto client_access = ClientAccess::of(token, access, nullptr);
  const bool has_known_token = client_access && client_access->has_token();
  if (!has_known_token) {
    // Replaces the name set by the previous request.
    context.client->set_identity(access ? access->owner_of(token) : "", false);
    if (auto refusal = above_rate()) co_return refusal;
  }
  context.service_client = context_.server.service.open(context.client);
  context.service_client->set_request_id(context.number);
  const auto known = co_await context.service_client->log_in(token);
  if (!known) co_return context.refused(known.error());
  if (has_known_token) {
    if (auto refusal = above_rate()) co_return refusal;
  }
  if (is_counted) {
    RequestFacts facts;
    facts.kind = context.kind;
    facts.id = context.request_id;
    facts.dataset = found.values.empty() ? std::string() : found.values.front();
    context.record = std::make_unique<RequestRecord>(context.client, std::move(facts));
  }
  co_return std::nullopt;
}

MakeListener http_listener(HttpOptions options, RouteOptions routes) {
  return [options = std::move(options),
          routes = std::move(routes)](const ServerContext& server) -> std::unique_ptr<Listener> {
    return std::make_unique<HttpListener>(
        server, options, std::make_unique<Router>(ResourceContext{server, options, routes}));
  };
}

}  // namespace multitetra
