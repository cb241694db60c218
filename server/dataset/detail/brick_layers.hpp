// Slices of samples into bricks, on their way into a prepared volume.
//
// Slices come a few at a time, in order, and leave in the order of their bricks. Where a layer of
// bricks is too large for one slab it is put aside, and then read in rows of bricks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "server/core/spectrum/sample_bricks.hpp"
#include "server/dataset/detail/prepared_sinks.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

// Boxes of samples, each a number of whole bricks, in the order of their bricks.
class BrickAssembler {
 public:
  // Valid until the next call.
  [[nodiscard]] std::span<const std::byte> bricks(const Samples& box, const GridCounts& dims);

 private:
  template <typename Sample>
  void rearrange(const std::vector<Sample>& samples, const BrickLayout& box);

  std::vector<std::byte> bytes_;
};

class BrickLayers {
 public:
  // Slices of a whole layer.
  static constexpr std::int32_t kSlices = BrickLayout::kSampleSide;

  // The sink must outlive it.
  BrickLayers(const VolumeHeader& header, PreparedSink& sink);

  // The next slices, all of one layer of bricks.
  void add(const Samples& slab, std::int32_t slices);

 private:
  void flush();
  template <typename Sample>
  void add_row(std::int32_t y, const GridCounts& box);

  GridCounts dims_;
  SampleType type_;
  std::size_t slice_bytes_;
  PreparedSink& sink_;
  BrickAssembler brick_assembler_;
  std::int32_t layer_begin_ = 0;
  std::unique_ptr<Scratch> scratch_;
  std::int32_t slices_in_layer_ = 0;        // Put aside.
  std::vector<std::uint64_t> aside_;        // Where in the scratch.
  std::vector<std::int32_t> slices_aside_;  // How many each time.
  Samples row_;
};

}  // namespace multitetra
