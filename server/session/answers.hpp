// Properties of server messages.
#pragma once

#include <cstdint>
#include <string_view>

#include "common/wire/messages.hpp"

namespace multitetra {

// Returns the id of the request this message answers, or 0 if it answers none.
[[nodiscard]] std::uint64_t request_id_of(const ServerMessage& message);

// Returns whether the message ends its stream.
[[nodiscard]] bool is_last(const ServerMessage& message);

// Returns the outcome of a stream from its last message, for log and metrics.
[[nodiscard]] std::string_view outcome_of(const ServerMessage& last);

// Returns whether the server is shutting down and accepts no new requests.
[[nodiscard]] bool is_shutdown_notice(const ServerMessage& message);

}  // namespace multitetra
