// Resources for operators: /livez, /readyz, /metrics, and /v1/openapi.json.
#pragma once

#include <string>
#include <string_view>

#include "server/http/answer.hpp"
#include "server/transport/listener.hpp"

namespace multitetra {

[[nodiscard]] Answer liveness_answer();
[[nodiscard]] Answer readiness_answer(const ServerContext& server, std::string_view request_id);
[[nodiscard]] Answer metrics_answer(const ServerContext& server, std::string_view request_id);
[[nodiscard]] Answer description_answer(const HttpRequest& request);

}  // namespace multitetra
