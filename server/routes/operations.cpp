// Resources for operators: /livez, /readyz, /metrics, and /v1/openapi.json.
#include "server/routes/openapi.hpp"
#include "server/routes/resource.hpp"
#include "server/service/surface_service.hpp"

namespace multitetra {
namespace {

HttpResponse ok_answer() {
  HttpResponse response = json_answer(200, "{\"status\":\"ok\"}\n");
  add_field(response, "Cache-Control", "no-store");
  return response;
}

HttpResponse readiness_answer(const ServerContext& server, std::string_view request_id) {
  if (const auto work = server.admission.check_draining(); !work) {
    return error_answer(work.error(), request_id);
  }
  if (server.service.is_ready()) return ok_answer();
  return error_answer({ErrorCode::kUnavailable, "The server does not accept new requests now."},
                      request_id);
}

HttpResponse metrics_answer(const ServerContext& server, std::string_view request_id) {
  if (!server.metrics) {
    return error_answer(404, {ErrorCode::kInvalidArgument, "This server does not provide metrics."},
                        request_id);
  }
  HttpResponse response{.body = body_of(server.metrics())};
  add_field(response, "Content-Type", "text/plain; version=0.0.4; charset=utf-8");
  add_field(response, "Cache-Control", "no-store");
  return response;
}

}  // namespace

Resource liveness_resource(const ResourceContext&) {
  return {
      .name = "livez",
      .path = "/livez",
      .kind = Resource::Kind::kProbe,
      .answer = [](ResourceRequest) -> asio::awaitable<HttpResponse> { co_return ok_answer(); }};
}

Resource readiness_resource(const ResourceContext& context) {
  return {.name = "readyz",
          .path = "/readyz",
          .kind = Resource::Kind::kProbe,
          .answer = [&context](ResourceRequest request) -> asio::awaitable<HttpResponse> {
            co_return readiness_answer(context.server, request.context.request_id);
          }};
}

Resource metrics_resource(const ResourceContext& context) {
  return {.name = "metrics",
          .path = "/metrics",
          .kind = Resource::Kind::kProbe,
          .answer = [&context](ResourceRequest request) -> asio::awaitable<HttpResponse> {
            co_return metrics_answer(context.server, request.context.request_id);
          }};
}

Resource api_description_resource(const ResourceContext&) {
  return {.name = "openapi",
          .path = "/v1/openapi.json",
          .kind = Resource::Kind::kFree,
          .answer = [](ResourceRequest request) -> asio::awaitable<HttpResponse> {
            co_return document_answer(api_description(), request.http);
          }};
}

}  // namespace multitetra
