// The memory to reserve for requests and replies, from when a request waits for workers until its
// reply is sent. An upper estimate: shared data, such as a cached tile, counts once per user.
#pragma once

#include <cstddef>

#include "common/wire/messages.hpp"
#include "server/service/dataset_queries.hpp"

namespace multitetra {

// Returns the bytes to reserve for a stream request until it is answered.
[[nodiscard]] std::size_t waiting_bytes(const OpenStream& open);
// Returns the bytes to reserve for a query and its reply, whose size follows from the query, until
// the reply is sent.
[[nodiscard]] std::size_t waiting_bytes(const DatasetQuery& query);
// Returns the bytes to reserve for a reply without a query until it is sent: 0 for messages of a
// few bytes, whose number is limited.
[[nodiscard]] std::size_t waiting_bytes(const ServerMessage& message);

}  // namespace multitetra
