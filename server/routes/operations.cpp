#include "server/routes/operations.hpp"

#include "server/routes/openapi.hpp"
#include "server/service/surface_service.hpp"

namespace multitetra {

Answer liveness_answer() {
  Answer answer = json_answer(200, "{\"status\":\"ok\"}\n");
  add_field(answer, "Cache-Control", "no-store");
  return answer;
}

Answer readiness_answer(const ServerContext& server, std::string_view request_id) {
  if (const auto work = server.admission.check_draining(); !work) {
    return error_answer(work.error(), request_id);
  }
  if (server.service.is_ready()) return liveness_answer();
  return error_answer({ErrorCode::kUnavailable, "The server does not accept new requests now."},
                      request_id);
}

Answer metrics_answer(const ServerContext& server, std::string_view request_id) {
  if (!server.metrics) {
    return error_answer(404, {ErrorCode::kInvalidArgument, "This server does not provide metrics."},
                        request_id);
  }
  Answer answer{.body = body_of(server.metrics())};
  add_field(answer, "Content-Type", "text/plain; version=0.0.4; charset=utf-8");
  add_field(answer, "Cache-Control", "no-store");
  return answer;
}

Answer description_answer(const HttpRequest& request) {
  return document_answer(std::string(kOpenApi), request);
}

}  // namespace multitetra
