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
#include "server/dataset/dataset_writer.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

class BrickLayers {
 public:
  // Slices in a full layer.
  static constexpr std::int32_t kSlices = BrickLayout::kSampleSide;

  // `sink` must outlive this object.
  BrickLayers(const VolumeHeader& header, BrickSink& sink);

  // Adds the next slices, which must lie in one layer of bricks.
  void add(const Samples& slab, std::int32_t slices);

 private:
  void flush();
  template <typename Sample>
  void add_row(std::int32_t y, const GridCounts& box);
  // Adds a box of whole bricks: rearranges them so that each is contiguous, in brick order.
  template <typename Sample>
  void add_bricks(const std::vector<Sample>& samples, const BrickLayout& box);

  GridCounts dims_;
  SampleType type_;
  std::size_t slice_bytes_;
  BrickSink& sink_;
  std::int32_t layer_begin_ = 0;
  std::unique_ptr<Scratch> scratch_;
  std::int32_t slices_in_layer_ = 0;    // In the scratch space, one after another.
  std::uint64_t scratch_begin_ = 0;     // Offset of the first of them.
  std::vector<std::byte> brick_bytes_;  // Of the box that is being added.
};

}  // namespace multitetra
