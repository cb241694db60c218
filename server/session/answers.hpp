// The request id of a server's message.
#pragma once

#include <cstdint>
#include <string_view>

#include "common/wire/messages.hpp"

namespace multitetra {

// The request that it answers; 0 when it is none's.
[[nodiscard]] std::uint64_t request_id_of(const ServerMessage& message);

// Whether nothing more of its stream follows.
[[nodiscard]] bool is_last(const ServerMessage& message);

// The outcome of a stream, from its last message: for the log and the metrics.
[[nodiscard]] std::string_view outcome_of(const ServerMessage& last);

// The server is shutting down and accepts no new requests.
[[nodiscard]] bool is_shutdown_notice(const ServerMessage& message);

}  // namespace multitetra
