// What an answer of a server says to who passes it on.
#pragma once

#include <cstdint>

#include "common/wire/messages.hpp"

namespace multitetra {

// The request that it answers; 0 when it is none's.
[[nodiscard]] std::uint64_t request_id_of(const ServerMessage& message);

// Nobody asked for an end: the server is going away, and takes nothing new.
[[nodiscard]] bool is_about_stopping(const ServerMessage& message);

// Whether nothing more of its request follows.
[[nodiscard]] bool is_last(const ServerMessage& message);

}  // namespace multitetra
