#include "server/operations/heap_trimmer.hpp"

#include <malloc.h>

#include <utility>

namespace multitetra {

void configure_allocator() {
  constexpr int kMaxArenas = 4;
  constexpr int kMmapThreshold = 16 << 20;
  constexpr int kTrimThreshold = 64 << 20;
  constexpr int kTopPad = 1 << 20;
  ::mallopt(M_ARENA_MAX, kMaxArenas);
  // An explicit threshold is static; by default it grows with freed blocks, up to 32 MiB.
  ::mallopt(M_MMAP_THRESHOLD, kMmapThreshold);
  // Simplification continually frees and allocates blocks of a few MiB. Getting their pages from
  // the system each time would cost a twentieth of the processor time.
  ::mallopt(M_TRIM_THRESHOLD, kTrimThreshold);
  ::mallopt(M_TOP_PAD, kTopPad);
}

bool HeapTrimmer::is_due(Clock::time_point now, std::uint64_t work, bool is_busy) {
  if (std::exchange(work_, work) != work || is_busy) {
    is_trim_pending_ = true;
    idle_since_ = now;
  }
  if (!is_trim_pending_ || (now - idle_since_ < kIdleTime && now - done_ < kPause)) return false;
  is_trim_pending_ = is_busy;
  done_ = now;
  return true;
}

void return_free_memory() { ::malloc_trim(0); }

}  // namespace multitetra
