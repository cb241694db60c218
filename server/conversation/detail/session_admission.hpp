// A session under the admission control's eyes: what holds before a message reaches it, and how its
// requests are reported. For all kinds of sessions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "server/operations/admission_control.hpp"
#include "server/session/session.hpp"

namespace multitetra {

// The actions that follow from a client's message.
struct Received {
  Actions actions;
  ByteReservations::Reservation reservation =
      {};                  // For the request that one of the actions begins.
  double retry_after = 0;  // Seconds, of a request that was refused before the session saw it.
};

// A draining admission lets no new work begin, another list of tokens holds at once, and requests
// beyond the client's rate, or for which no memory can be reserved, are answered without the
// session. `message_bytes` is how long the message was.
[[nodiscard]] Received receive_from(ConnectionContext& client, Session& session,
                                    const tl::expected<ClientMessage, ParseError>& message,
                                    std::size_t message_bytes);

[[nodiscard]] RequestFacts facts_of(const char* kind, std::uint64_t id, const std::string& dataset,
                                    const IsosurfaceRequest& request);
[[nodiscard]] RequestFacts facts_of(const DatasetQuery& query);

}  // namespace multitetra
