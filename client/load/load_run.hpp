// Runs many sessions on few threads, from start to end.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "client/load/load_session.hpp"
#include "client/load/misbehaviour.hpp"

namespace multitetra {

// The local addresses from which simulated clients connect.
class SourceAddresses {
 public:
  // The system chooses.
  SourceAddresses() = default;
  // Accepts an IPv4 network, "127.0.1.0/24", without its first and last address, or one address.
  [[nodiscard]] static Result<SourceAddresses> from(std::string_view text);

  [[nodiscard]] std::size_t count() const { return count_; }  // 0: the system chooses.
  // Returns the address of a client, counted from 0; addresses are used in turn.
  [[nodiscard]] std::string of(std::size_t client) const;

 private:
  std::uint32_t first_ = 0;
  std::size_t count_ = 0;
};

struct LoadOptions {
  // start, stop and give_up are set by run_load().
  UserOptions session;
  std::uint64_t seed = 1;
  std::size_t clients = 10;
  std::size_t idle = 0;  // Additional clients that only stay connected.
  int threads = 1;
  // Clients use these addresses in turn.
  SourceAddresses from = {};
  std::chrono::milliseconds duration{10'000};
  // Clients connect evenly spread over this time.
  std::chrono::milliseconds ramp{1'000};
  // Extra time for streams that run when the duration ends.
  std::chrono::milliseconds grace{30'000};
};

[[nodiscard]] LoadStatistics run_load(const LoadOptions& options);
[[nodiscard]] MisbehaviourCounts run_misbehaviour(Misbehaviour kind, const LoadOptions& options);

// Raises this process's file limit for `count` connections. Returns kLimitExceeded, with a remedy,
// if the system does not permit them.
[[nodiscard]] Result<void> allow_connections(std::size_t count);

}  // namespace multitetra
