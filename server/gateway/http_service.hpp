// What is answered to an HTTP request.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "common/net.hpp"
#include "server/gateway/answer.hpp"
#include "server/gateway/http_options.hpp"
#include "server/gateway/http_request.hpp"
#include "server/service/door.hpp"

namespace multitetra {

// The request was a good one for a WebSocket, which takes over the connection.
struct UpgradeToWebSocket {};
using Outcome = std::variant<Answer, UpgradeToWebSocket>;

class HttpService {
 public:
  // Both outlive the service.
  HttpService(const House& house, const HttpOptions& options);

  // Never throws for what a client sent.
  [[nodiscard]] asio::awaitable<Outcome> answer(const HttpRequest& request,
                                                std::string_view request_id);
  // Names a request in its answer and in the log.
  [[nodiscard]] std::string new_request_id();
  [[nodiscard]] DialoguePtr new_dialogue(const std::string& peer) const {
    return house_.new_dialogue(peer);
  }

 private:
  [[nodiscard]] Outcome upgrade(const HttpRequest& request, std::string_view request_id) const;

  const House& house_;
  const HttpOptions& options_;
  std::uint64_t next_request_;  // Begins anywhere, so that ids of two runs do not meet.
};

}  // namespace multitetra
