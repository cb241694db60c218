// What a spectrum is made from, and where bytes are put aside meanwhile. Whoever has files
// implements both.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "server/core/framework/grid.hpp"
#include "server/core/framework/volume.hpp"

namespace multitetra {

// A volume whose samples are read box by box, in any order. Safe to use from several threads at
// once.
class SampleBoxes {
 public:
  virtual ~SampleBoxes() = default;
  // The samples first ... first + extent - 1, x fastest, of the volume's type. What `into` held is
  // lost; its memory is used again. Requires that all of them are samples of the volume.
  virtual void read(GridPoint first, GridPoint extent, Samples& into) const = 0;
};

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
