// The memory of requests and their replies, from when a request waits for workers until its
// answer has been sent. Rather too much than too little; what several share, such as a cached tile,
// counts for each.
#pragma once

#include <cstddef>

#include "common/wire/messages.hpp"
#include "server/service/dataset_queries.hpp"

namespace multitetra {

// As long as the request is not answered.
[[nodiscard]] std::size_t waiting_bytes(const OpenStream& open);
// With its reply, whose size follows from the query: until that has been sent.
[[nodiscard]] std::size_t waiting_bytes(const DatasetQuery& query);
// For a reply without a query until it has been sent; 0 for those of a few bytes, of which only
// so many may wait.
[[nodiscard]] std::size_t waiting_bytes(const ServerMessage& message);

}  // namespace multitetra
