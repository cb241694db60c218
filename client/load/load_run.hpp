// Runs many sessions on few threads, from start to end.
#pragma once

#include <cstdint>

#include "client/load/load_session.hpp"
#include "client/load/misbehaviour.hpp"
#include "client/load/source_addresses.hpp"

namespace multitetra {

struct LoadOptions {
  UserOptions session;  // start, stop and give_up are filled in here.
  std::uint64_t seed = 1;
  std::size_t clients = 10;
  std::size_t idle = 0;  // Further clients that only stay connected.
  int threads = 1;
  SourceAddresses from = {};  // Each client connects from the next one.
  std::chrono::milliseconds duration{10'000};
  std::chrono::milliseconds ramp{1'000};    // The clients connect evenly over this time.
  std::chrono::milliseconds grace{30'000};  // For streams that run when the duration is over.
};

[[nodiscard]] LoadStatistics run_load(const LoadOptions& options);
[[nodiscard]] MisbehaviourCounts run_misbehaviour(Misbehaviour kind, const LoadOptions& options);

// Makes room for so many connections of this process. kLimitExceeded, saying what to do, when the
// system does not allow them.
[[nodiscard]] Result<void> allow_connections(std::size_t count);

}  // namespace multitetra
