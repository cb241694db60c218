// XXH3-64 with seed 0. Detects accidental damage; no protection against deliberate changes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

struct XXH3_state_s;

namespace multitetra {

[[nodiscard]] std::uint64_t checksum(std::span<const std::byte> bytes);

// Computes the checksum of bytes that arrive in pieces.
class RunningChecksum {
 public:
  RunningChecksum();
  void add(std::span<const std::byte> bytes);
  [[nodiscard]] std::uint64_t value() const;  // Covers all bytes so far.

 private:
  struct Free {
    void operator()(XXH3_state_s* state) const;
  };
  std::unique_ptr<XXH3_state_s, Free> state_;
};

}  // namespace multitetra
