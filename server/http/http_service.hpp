// What is answered to an HTTP request.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "common/net/net.hpp"
#include "server/http/answer.hpp"
#include "server/http/http_options.hpp"
#include "server/http/http_request.hpp"
#include "server/http/neuroglancer_service.hpp"
#include "server/http/one_shot_session.hpp"
#include "server/http/request_context.hpp"
#include "server/http/route.hpp"
#include "server/http/slice_service.hpp"
#include "server/http/surface_service.hpp"
#include "server/http/tree_service.hpp"
#include "server/transport/listener.hpp"

namespace multitetra {

// The request was a good one for a WebSocket, which takes over the connection.
struct UpgradeToWebSocket {};
using Outcome = std::variant<Answer, UpgradeToWebSocket>;

class HttpService {
 public:
  // Both outlive the service.
  HttpService(const ServerContext& server, const HttpOptions& options);

  // Never throws for what a client sent. Request and context live until it is answered.
  [[nodiscard]] asio::awaitable<Outcome> answer(const HttpRequest& request,
                                                RequestContext& context);

  // Names a request in its answer and in the log.
  [[nodiscard]] std::string new_request_id();
  [[nodiscard]] StreamSessionPtr new_session(const ClientContextPtr& client) const {
    return server_.new_session(client);
  }

 private:
  // What a route is answered with; without what all answers have in common.
  struct Question {
    const HttpRequest& request;
    const Target& target;
    RequestContext& context;
  };
  asio::awaitable<Outcome> routed(const HttpRequest& request, RequestContext& context);
  asio::awaitable<Answer> inquired(const Route& route, Question asked);
  Answer answer_to(const Liveness&, const Question& asked) const;
  Answer answer_to(const Readiness&, const Question& asked) const;
  Answer answer_to(const Metrics&, const Question& asked) const;
  Answer answer_to(const Description&, const Question& asked) const;
  asio::awaitable<Answer> answer_tile(ContentDigest digest, Question asked) const;
  Answer answer_to(const ViewerFile& file, const Question& asked) const;

  const ServerContext& server_;
  const HttpOptions& options_;
  SurfaceService surfaces_;
  SliceService slices_;
  TreeService trees_;
  NeuroglancerService neuroglancer_;
  std::uint64_t next_request_;  // Begins anywhere, so that ids of two runs do not meet.
};

}  // namespace multitetra
