// What one client may take of a server's time. Zero is no limit.
#pragma once

#include <chrono>
#include <cstdint>

namespace multitetra {

struct ServiceLimits {
  std::chrono::milliseconds request_time{0};  // Of workers, for one request.
  std::uint64_t max_triangles = 0;            // Of a final step.
  std::chrono::milliseconds waiting_time{0};  // Expected of all that one share asked for.
};

}  // namespace multitetra
