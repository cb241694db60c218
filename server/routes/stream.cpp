// /v1/stream: the conversation over a WebSocket.
#include "server/http/upgrade.hpp"
#include "server/routes/resource.hpp"

namespace multitetra {

Resource stream_resource(const ResourceContext& context) {
  return {.name = "stream",
          .path = "/v1/stream",
          .kind = Resource::Kind::kFree,
          .answer = [&context](ResourceRequest request) -> asio::awaitable<HttpResponse> {
            co_return upgrade_answer(request.http, context.http.allowed_origins,
                                     request.context.request_id);
          }};
}

}  // namespace multitetra
