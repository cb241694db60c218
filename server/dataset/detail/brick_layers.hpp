// Converts slices of samples into bricks for a prepared volume.
//
// Slices arrive a few at a time, in order; bricks leave in the order of the dataset. If a layer of
// bricks is too large for one slab, its slices are buffered and then read in rows of bricks.
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

// Rearranges boxes of whole bricks so that each brick is contiguous, in brick order.
class BrickAssembler {
 public:
  // Returns the bytes of all bricks of the box, valid until the next call.
  [[nodiscard]] std::span<const std::byte> bricks(const Samples& box, const GridCounts& dims);

 private:
  template <typename Sample>
  void rearrange(const std::vector<Sample>& samples, const BrickLayout& box);

  std::vector<std::byte> bytes_;
};

class BrickLayers {
 public:
  // Slices in a full layer.
  static constexpr std::int32_t kSlices = BrickLayout::kSampleSide;

  // `sink` must outlive this object.
  BrickLayers(const VolumeHeader& header, PreparedSink& sink);

  // Adds the next slices, which must lie in one layer of bricks.
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
  std::int32_t slices_in_layer_ = 0;  // Buffered.
  // Offset of each buffered slab in the scratch space.
  std::vector<std::uint64_t> buffered_offsets_;
  std::vector<std::int32_t> buffered_slices_;  // Number of slices of each buffered slab.
  Samples row_;
};

}  // namespace multitetra
