// Misbehaving clients, to test their effect on other clients. Each is a coroutine. A connection
// closed by the server is counted and is not an error.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <random>
#include <string_view>

#include "client/load/load_session.hpp"

namespace multitetra {

enum class Misbehaviour {
  kStalled,  // Requests surfaces repeatedly and reads nothing.
  kSlow,     // Sends one byte of its greeting per second.
  // Disconnects in the middle of a conversation.
  kLeaving,
  kGarbage,   // Sends bytes that are not a message.
  kGreedy,    // Requests the most work allowed, never the same twice, and reads the replies.
  kHoarding,  // Requests what takes the most memory, at the highest rate, and reads nothing.
};
[[nodiscard]] std::optional<Misbehaviour> misbehaviour_from(std::string_view name);
[[nodiscard]] std::string_view name(Misbehaviour kind);  // "stalled", "slow", ...

struct MisbehaviourCounts {
  std::uint64_t connections = 0;
  std::uint64_t failed_attempts = 0;
  std::uint64_t ended_by_server = 0;
  std::uint64_t bytes_sent = 0;

  void add(const MisbehaviourCounts& other);
};

// Runs until options.stop and reconnects whenever a connection ends. Connects from the address
// `from` unless it is empty. All references must outlive the coroutine.
[[nodiscard]] asio::awaitable<void> misbehave(Misbehaviour kind, const UserOptions& options,
                                              std::uint64_t seed, std::chrono::milliseconds delay,
                                              std::string from, MisbehaviourCounts& counts);

}  // namespace multitetra
