// What one client may take of a server's time and memory. Zero is no limit.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace multitetra {

// Replies that wait until the client takes them; reading pauses beyond that.
inline constexpr std::size_t kMaxWaitingReplies = 64;

struct SessionLimits {
  std::chrono::milliseconds request_time{0};  // Of workers, for one stream or estimate.
  std::chrono::milliseconds idle_time{0};     // Without a message from the client or a stream.
  std::uint64_t max_triangles = 0;            // Of a final step.
  std::chrono::milliseconds waiting_time{0};  // Expected of all that one share asked for.
};

}  // namespace multitetra
