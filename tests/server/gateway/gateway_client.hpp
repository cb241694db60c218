// Helpers for a client of a gateway over a WebSocket. The dataset is the octahedron.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "tests/support/fake_steps.hpp"
#include "tests/support/running_http_server.hpp"

namespace multitetra::testing {

inline std::shared_ptr<FakeSteps> octahedron() { return std::make_shared<FakeSteps>("octahedron"); }

inline ServerMessage greeted(WebSocketClient& client, const std::string& token = {}) {
  client.send(Hello{.token = token});
  return client.receive();
}

inline bool is_welcome(const ServerMessage& message) {
  return std::holds_alternative<Welcome>(message);
}

inline ErrorCode code_of(const ServerMessage& message) {
  const auto* reply = std::get_if<ErrorReply>(&message);
  return reply ? reply->error.code : ErrorCode::kUnknown;
}

inline void open(WebSocketClient& client, std::uint64_t id, std::string dataset = "octahedron") {
  client.send(
      OpenStream{.request_id = id, .dataset = std::move(dataset), .cached_tile_digests = {}});
}

// The last message of the running stream.
inline ServerMessage end_of_stream(WebSocketClient& client) {
  for (;;) {
    ServerMessage message = client.receive();
    if (std::holds_alternative<StreamEnd>(message) || std::holds_alternative<ErrorReply>(message))
      return message;
  }
}

// All messages of the running stream.
inline std::vector<ServerMessage> all_of_stream(WebSocketClient& client) {
  std::vector<ServerMessage> messages;
  do {
    messages.push_back(client.receive());
  } while (!std::holds_alternative<StreamEnd>(messages.back()) &&
           !std::holds_alternative<ErrorReply>(messages.back()));
  return messages;
}

inline bool is_complete(const ServerMessage& last) {
  const auto* end = std::get_if<StreamEnd>(&last);
  return end && end->outcome == StreamOutcome::kComplete;
}

// Returns a tile as soon as the gateway has checked and cached it, or 404 after ten seconds.
inline HttpClient::Response kept_tile(HttpClient& client, const ContentDigest& digest,
                                      std::string_view fields = {}) {
  const std::string path = "/v1/tiles/" + digest.hex();
  HttpClient::Response response = client.get(path, fields);
  for (int i = 0; i < 500 && response.result_int() == 404; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    response = client.get(path, fields);
  }
  return response;
}

}  // namespace multitetra::testing
