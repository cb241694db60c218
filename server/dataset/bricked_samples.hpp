// Reads boxes of samples from bricks.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "server/core/spectrum/sample_bricks.hpp"
#include "server/core/spectrum/spectrum_inputs.hpp"

namespace multitetra {

class BrickedSamples : public SampleBoxes {
 public:
  // Reads bytes.size() bytes: brick `first` and those that follow it along x. Called from several
  // threads at once.
  using ReadBricks = std::function<void(std::size_t first, std::span<std::byte> bytes)>;

  BrickedSamples(const GridCounts& dims, SampleType type, ReadBricks read)
      : layout_(dims), type_(type), read_(std::move(read)) {}

  void read(GridPoint first, GridPoint extent, Samples& into) const override;

 private:
  template <typename Sample>
  void read_typed(GridPoint first, GridPoint end, std::vector<Sample>& into) const;

  BrickLayout layout_;
  SampleType type_;
  ReadBricks read_;
};

}  // namespace multitetra
