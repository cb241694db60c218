// Temporary storage of bytes outside of memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace multitetra {

// A place for bytes that need not stay in memory. Safe to use from several threads at once.
class Scratch {
 public:
  virtual ~Scratch() = default;
  // Keeps the bytes; what it returns finds them again. Not the same from run to run.
  [[nodiscard]] virtual std::uint64_t put(std::span<const std::byte> bytes) = 0;
  // The bytes that begin `offset` bytes into the scratch. Requires that all of them were put.
  virtual void get(std::uint64_t offset, std::span<std::byte> into) const = 0;
};

}  // namespace multitetra
