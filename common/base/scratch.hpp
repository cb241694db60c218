// Temporary storage outside of memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace multitetra {

// Stores bytes that need not stay in memory. Thread-safe.
class Scratch {
 public:
  virtual ~Scratch() = default;
  // Stores the bytes and returns their offset for get(). Offsets may differ from run to run.
  [[nodiscard]] virtual std::uint64_t put(std::span<const std::byte> bytes) = 0;
  // Reads the bytes at `offset`. Requires that all of them were stored.
  virtual void get(std::uint64_t offset, std::span<std::byte> into) const = 0;
};

}  // namespace multitetra
