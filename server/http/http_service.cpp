#include "server/http/http_service.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <random>
#include <utility>

#include <nlohmann/json.hpp>

#include "common/cli/json_report.hpp"
#include "server/http/host.hpp"
#include "server/http/openapi.hpp"
#include "server/http/origin.hpp"
#include "server/http/upgrade.hpp"
#include "server/http/viewer_answer.hpp"

namespace multitetra {
namespace {

constexpr std::string_view kMethods = "GET, HEAD, OPTIONS";

std::string_view bearer_token(const HttpRequest& request) {
  constexpr std::string_view kScheme = "Bearer ";
  const std::string_view said = field(request, http::field::authorization);
  if (said.size() < kScheme.size() ||
      !boost::beast::iequals({said.data(), kScheme.size()}, {kScheme.data(), kScheme.size()}))
    return {};
  return said.substr(kScheme.size());
}

// Memory that nobody else has, until the answer has left. Small ones are part of the connection.
std::size_t waiting_bytes(const Answer& answer) {
  constexpr std::size_t kSmall = 16 * 1024;
  const auto* text = std::get_if<std::string>(&answer.body.whole);
  return text != nullptr && text->size() > kSmall ? text->size() : 0;
}

Answer methods_answer() {
  Answer answer{.status = 204};
  add_field(answer, "Allow", kMethods);
  return answer;
}

Answer not_offered(std::string_view what, std::string_view request_id) {
  return error_answer(
      404, {ErrorCode::kInvalidArgument, "This server offers no " + std::string(what) + "."},
      request_id);
}

// JSON that is asked for again and again, and changes seldom.
Answer document(std::string json, const HttpRequest& request) {
  const std::string tag = tag_of(json);
  Answer answer = json_answer(200, std::move(json));
  add_field(answer, "Cache-Control", "no-cache");
  meet_conditions(answer, request, tag);
  return answer;
}

// The list goes without histograms: they are in each dataset's own description.
std::string listing(const std::vector<DatasetInfo>& infos) {
  Json list = Json::array();
  for (const DatasetInfo& info : infos) {
    list.push_back(json_of(info));
    list.back().erase("histogram");
  }
  return text_of({{"datasets", std::move(list)}});
}

}  // namespace

HttpService::HttpService(const ServerContext& server, const HttpOptions& options)
    : server_(server),
      options_(options),
      surfaces_(options),
      trees_(options),
      neuroglancer_(options),
      next_request_((std::uint64_t{std::random_device{}()} << 32) | 1) {}

std::string HttpService::new_request_id() {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx",
                static_cast<unsigned long long>(next_request_++));
  return text.data();
}

asio::awaitable<Outcome> HttpService::answer(const HttpRequest& request, RequestContext& context) {
  Outcome outcome = co_await routed(request, context);
  if (const auto* answer = std::get_if<Answer>(&outcome)) {
    auto room = context.client->take_room(waiting_bytes(*answer));
    if (room) {
      context.room = *std::move(room);
    } else {
      outcome = error_answer(room.error(), context.request_id);
    }
  }
  if (auto* answer = std::get_if<Answer>(&outcome)) {
    add_field(*answer, "X-Request-Id", context.request_id);
    answer->fields +=
        cross_origin_fields(field(request, http::field::origin), field(request, http::field::host),
                            options_.allowed_origins, request.method() == http::verb::options);
  }
  co_return outcome;
}

asio::awaitable<Outcome> HttpService::routed(const HttpRequest& request, RequestContext& context) {
  const std::string_view host = field(request, http::field::host);
  if (!is_allowed_host(host, options_.allowed_hosts)) {
    co_return error_answer(
        421,
        {ErrorCode::kInvalidArgument, "This server is not asked as \"" + std::string(host) +
                                          "\"; whoever runs it can allow that with --allow-host."},
        context.request_id);
  }
  if (request.method() == http::verb::options && request.target() == "*") {
    co_return methods_answer();
  }
  const std::string_view path = without_authority(view_of(request.target()));
  if (is_base_path(path, options_.base_path)) {
    Answer answer{.status = 308};
    add_field(answer, "Location", options_.base_path + "/");
    co_return answer;
  }
  const auto target = parse_target(without_base_path(path, options_.base_path));
  const auto route = target ? route_of(*target) : Result<Route>(tl::unexpected(target.error()));
  if (!route) co_return error_answer(route.error(), context.request_id);
  context.kind = name(*route);
  if (request.method() == http::verb::options) {
    co_return methods_answer();
  }
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    Answer answer = error_answer(
        405,
        {ErrorCode::kInvalidArgument, "The method here is GET or HEAD, not " +
                                          std::string(view_of(request.method_string())) + "."},
        context.request_id);
    add_field(answer, "Allow", kMethods);
    co_return answer;
  }
  const Question asked = {.request = request, .target = *target, .context = context};
  if (std::holds_alternative<WebSocketStream>(*route)) {
    auto objection = upgrade_objection(request, options_.allowed_origins, context.request_id);
    if (objection) co_return *std::move(objection);
    co_return UpgradeToWebSocket{};
  }
  if (const auto* tile = std::get_if<TileBytes>(&*route)) {
    co_return co_await answer_tile(tile->digest, asked);
  }
  if (const auto* file = std::get_if<ViewerFile>(&*route)) co_return answer_to(*file, asked);
  if (std::holds_alternative<Liveness>(*route)) co_return answer_to(Liveness{}, asked);
  if (std::holds_alternative<Readiness>(*route)) co_return answer_to(Readiness{}, asked);
  if (std::holds_alternative<Metrics>(*route)) co_return answer_to(Metrics{}, asked);
  if (std::holds_alternative<Description>(*route)) co_return answer_to(Description{}, asked);
  co_return co_await inquired(*route, asked);
}

asio::awaitable<Answer> HttpService::inquired(const Route& route, Question asked) {
  const std::string& id = asked.context.request_id;
  if (const auto allowed = asked.context.client->may_ask(); !allowed) {
    co_return error_answer(429, allowed.error(), id);
  }
  const auto* tree = std::get_if<TreeFile>(&route);
  const auto* neuroglancer = std::get_if<NeuroglancerFile>(&route);
  std::string token = tree != nullptr           ? tree->token
                      : neuroglancer != nullptr ? neuroglancer->token
                                                : std::string();
  if (token.empty()) token = bearer_token(asked.request);
  OneShotSession one_shot(server_.new_session(asked.context.client), asked.context);
  const auto welcome = co_await one_shot.greet(token);
  if (!welcome) co_return error_answer(welcome.error(), id);
  const bool is_for_all = token.empty() && !server_.admission.access();
  if (tree != nullptr) {
    co_return co_await trees_.answer(*tree, asked.request, one_shot, asked.context, is_for_all);
  }
  if (neuroglancer != nullptr) {
    co_return co_await neuroglancer_.answer(*neuroglancer, asked.request, one_shot, asked.context,
                                            is_for_all);
  }
  if (const auto* surface = std::get_if<SurfaceFile>(&route)) {
    co_return co_await surfaces_.answer(surface->dataset, asked.target, asked.request, one_shot,
                                        asked.context);
  }
  if (const auto* slice = std::get_if<SliceOfSamples>(&route)) {
    co_return co_await slices_.slice(slice->dataset, asked.target, asked.request, one_shot,
                                     asked.context);
  }
  if (const auto* value = std::get_if<ValueAtPlaces>(&route)) {
    co_return co_await slices_.value(value->dataset, asked.target, one_shot, asked.context);
  }
  if (const auto* one = std::get_if<DatasetDescription>(&route)) {
    const auto info = co_await one_shot.dataset(one->dataset);
    if (!info) co_return error_answer(info.error(), id);
    co_return document(text_of(json_of(*info)), asked.request);
  }
  const auto infos = co_await one_shot.datasets();
  if (!infos) co_return error_answer(infos.error(), id);
  co_return document(listing(*infos), asked.request);
}

Answer HttpService::answer_to(const Liveness&, const Question&) const {
  Answer answer = json_answer(200, "{\"status\":\"ok\"}\n");
  add_field(answer, "Cache-Control", "no-store");
  return answer;
}

Answer HttpService::answer_to(const Readiness&, const Question& asked) const {
  if (const auto work = server_.admission.may_begin_work(); !work) {
    return error_answer(work.error(), asked.context.request_id);
  }
  if (!options_.hooks.is_ready || options_.hooks.is_ready()) return answer_to(Liveness{}, asked);
  return error_answer({ErrorCode::kUnavailable, "The server takes no new work now."},
                      asked.context.request_id);
}

Answer HttpService::answer_to(const Metrics&, const Question& asked) const {
  if (!server_.metrics) return not_offered("metrics", asked.context.request_id);
  Answer answer{.body = body_of(server_.metrics())};
  add_field(answer, "Content-Type", "text/plain; version=0.0.4; charset=utf-8");
  add_field(answer, "Cache-Control", "no-store");
  return answer;
}

Answer HttpService::answer_to(const Description&, const Question& asked) const {
  return document(std::string(kOpenApi), asked.request);
}

// Whoever may see a dataset may have its tiles. Where tokens decide that, an answer is for their
// bearer alone.
asio::awaitable<Answer> HttpService::answer_tile(ContentDigest digest, Question asked) const {
  const HttpHooks& hooks = options_.hooks;
  const std::string& id = asked.context.request_id;
  if (!hooks.find_tile) co_return not_offered("tiles by their digest", id);
  const std::string token(bearer_token(asked.request));
  AccessRights rights;
  const AccessListPtr access = server_.admission.access();
  if (access) {
    auto known = access->rights_of(token);
    if (!known) co_return error_answer(known.error(), id);
    rights = *std::move(known);
  }
  CataloguePtr offered;
  if (hooks.catalogue_of) {
    auto found = co_await hooks.catalogue_of(token);
    if (!found) co_return error_answer(found.error(), id);
    offered = *std::move(found);
  }
  const auto may_see = [&](const std::string& dataset) {
    return rights.may_see(dataset) && (!offered || offered->find(dataset));
  };
  const auto found = hooks.find_tile(digest, may_see);
  if (!found) {
    co_return error_answer(404,
                           {ErrorCode::kInvalidArgument,
                            "The server does not hold this tile any more, or never had it; a "
                            "stream brings it."},
                           id);
  }
  const bool is_for_all = !access && (!offered || token.empty());
  Answer answer{.body = body_of(found->payload)};
  add_field(answer, "Content-Type", media_type(MeshFormat::kDrc));
  add_field(
      answer, "Cache-Control",
      is_for_all ? "public, max-age=31536000, immutable" : "private, max-age=31536000, immutable");
  meet_conditions(answer, asked.request, '"' + digest.hex() + '"');
  co_return answer;
}

Answer HttpService::answer_to(const ViewerFile& file, const Question& asked) const {
  return viewer_answer(*options_.viewer, file.path, asked.request, options_.allowed_origins,
                       asked.context.request_id);
}

}  // namespace multitetra
