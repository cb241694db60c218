// Applies admission control before a message reaches a session of any kind, and describes requests
// for logs.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "server/operations/admission_control.hpp"
#include "server/session/session.hpp"

namespace multitetra {

// The outcome of a client's message.
struct Received {
  Actions actions;
  // The memory reserved for the request that an action begins.
  ByteReservations::Reservation reservation = {};
  double retry_after = 0;  // Seconds, if the request was refused before it reached the session.
};

// Passes a message of `message_bytes` bytes to the session. First applies a new token list and
// draining to the session; requests that exceed the rate limit or the memory for reservations are
// answered without the session.
[[nodiscard]] Received receive_from(ConnectionContext& client, Session& session,
                                    const tl::expected<ClientMessage, ParseError>& message,
                                    std::size_t message_bytes);

[[nodiscard]] RequestFacts facts_of(const char* kind, std::uint64_t id, const std::string& dataset,
                                    const IsosurfaceRequest& request);
[[nodiscard]] RequestFacts facts_of(const DatasetQuery& query);

}  // namespace multitetra
