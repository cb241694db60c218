// What is answered to an HTTP request.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "common/net.hpp"
#include "server/gateway/answer.hpp"
#include "server/gateway/http_options.hpp"
#include "server/gateway/http_request.hpp"
#include "server/gateway/inquiry.hpp"
#include "server/gateway/route.hpp"
#include "server/gateway/surface_service.hpp"
#include "server/gateway/visit.hpp"
#include "server/service/door.hpp"

namespace multitetra {

// The request was a good one for a WebSocket, which takes over the connection.
struct UpgradeToWebSocket {};
using Outcome = std::variant<Answer, UpgradeToWebSocket>;

class HttpService {
 public:
  // Both outlive the service.
  HttpService(const House& house, const HttpOptions& options);

  // Never throws for what a client sent. Request and visit live until it is answered.
  [[nodiscard]] asio::awaitable<Outcome> answer(const HttpRequest& request, Visit& visit);

  // Names a request in its answer and in the log.
  [[nodiscard]] std::string new_request_id();
  [[nodiscard]] DialoguePtr new_dialogue(const GuestPtr& guest) const {
    return house_.new_dialogue(guest);
  }

 private:
  // What a route is answered with; without what all answers have in common.
  struct Question {
    const HttpRequest& request;
    const Target& target;
    Visit& visit;
  };
  asio::awaitable<Outcome> routed(const HttpRequest& request, Visit& visit);
  asio::awaitable<Answer> inquired(const Route& route, Question asked);
  Answer answer_to(const Liveness&, const Question& asked) const;
  Answer answer_to(const Readiness&, const Question& asked) const;
  Answer answer_to(const Metrics&, const Question& asked) const;
  Answer answer_to(const Description&, const Question& asked) const;
  Answer answer_to(const TileBytes& tile, const Question& asked) const;
  Answer answer_to(const ViewerFile& file, const Question& asked) const;

  const House& house_;
  const HttpOptions& options_;
  SurfaceService surfaces_;
  std::uint64_t next_request_;  // Begins anywhere, so that ids of two runs do not meet.
};

}  // namespace multitetra
