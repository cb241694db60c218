// --threads: the number of threads that a command uses.
#pragma once

#include "common/base/in_parallel.hpp"
#include "common/cli/command.hpp"

namespace multitetra {

inline void add_threads_option(Command& command, int& threads) {
  command.add_option("--threads", threads, "Threads for the work (default: one per processor)")
      ->within(1, 1024);
}

}  // namespace multitetra
