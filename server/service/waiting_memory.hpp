// How much memory messages take while somebody waits: a client's requests for workers, a server's
// answers for their client. Rather too much than too little; what all share with others, such as a
// cached tile, counts for each.
#pragma once

#include <cstddef>

#include "common/wire/messages.hpp"
#include "server/service/questions.hpp"

namespace multitetra {

// As long as the request is not answered.
[[nodiscard]] std::size_t waiting_bytes(const OpenStream& open);
[[nodiscard]] std::size_t waiting_bytes(const Question& question);
// Of a reply until it has left; 0 for those of a few bytes, of which only so many may wait.
[[nodiscard]] std::size_t waiting_bytes(const ServerMessage& message);

}  // namespace multitetra
