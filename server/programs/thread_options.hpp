// --threads: the number of threads that a command uses.
#pragma once

#include <memory>

#include <oneapi/tbb/global_control.h>

#include "common/cli/command.hpp"

namespace multitetra {

inline void add_threads_option(Command& command, int& threads) {
  command.add_option("--threads", threads, "Threads for the work (default: one per processor)")
      ->within(1, 1024);
}

// Limits oneTBB during its lifetime. 0: no limit.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads) {
    if (threads > 0) {
      limit_ = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                     static_cast<std::size_t>(threads));
    }
  }

 private:
  std::unique_ptr<tbb::global_control> limit_;
};

}  // namespace multitetra
