// Misbehaving clients, to test their effect on other clients. Each is a coroutine; a connection
// closed by the server is counted and is not an error.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <random>
#include <string_view>

#include "common/net/message_channel.hpp"

namespace multitetra {

enum class Misbehaviour {
  kStalled,  // Requests a surface, again and again, and reads nothing.
  kSlow,     // Sends a byte a second of what should be its greeting.
  // Connects, sends a part of a conversation, and disconnects in the middle.
  kLeaving,
  kGarbage,   // Sends what is no message.
  kGreedy,    // Requests the most work allowed, never the same twice, and reads the replies.
  kHoarding,  // Requests what takes the most memory, at the highest rate, and reads nothing.
};
[[nodiscard]] std::optional<Misbehaviour> misbehaviour_from(std::string_view name);
[[nodiscard]] std::string_view name(Misbehaviour kind);  // "stalled", "slow", ...

struct MisbehaviourOptions {
  Endpoint server;
  TlsContextPtr tls = nullptr;
  std::string token;
  std::string dataset;  // For requests; empty: the first that the server has.
  std::chrono::steady_clock::time_point start;
  std::chrono::steady_clock::time_point stop;
};

struct MisbehaviourCounts {
  std::uint64_t connections = 0;
  std::uint64_t failed_attempts = 0;
  std::uint64_t ended_by_server = 0;
  std::uint64_t bytes_sent = 0;

  void add(const MisbehaviourCounts& other);
};

// Until options.stop, reconnecting whenever a connection has ended, from the address `from` unless
// it is empty. All references must outlive
// it.
[[nodiscard]] asio::awaitable<void> misbehave(Misbehaviour kind, const MisbehaviourOptions& options,
                                              std::uint64_t seed, std::chrono::milliseconds delay,
                                              std::string from, MisbehaviourCounts& counts);

}  // namespace multitetra
