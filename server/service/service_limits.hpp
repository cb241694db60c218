// Limits on the worker time of one client. Zero means no limit.
#pragma once

#include <chrono>
#include <cstdint>

namespace multitetra {

struct ServiceLimits {
  std::chrono::milliseconds request_time{0};  // Worker time for one request.
  // The most triangles of a final step.
  std::uint64_t max_triangles = 0;
  // Expected worker time for all pending requests of a share.
  std::chrono::milliseconds waiting_time{0};
};

}  // namespace multitetra
