// Which bricks of a dataset lie together in an object. Both layouts follow from what every reader
// knows before it reads a brick, so no file has to say them.
//
// Samples: boxes of 8 x 8 x 8 bricks, 128^3 samples, whose bricks follow each other in Morton order
// (those of the lower half along z first, in each half those of the lower half along y, ...), and
// so do the boxes. What is near in the volume is near in an object.
//
// Spectrum: whole levels from the coarsest on, as long as they have kSpectrumObjectBytes together,
// in one object; then each finer level for itself: all of it if it has so many bytes at most, else
// each of its eight octants if it has, and so on. A level's bricks are in Morton order; a level's
// octants are cubes of a power of two bricks, seen from its lowest corner. Where nothing changed,
// an octant of a new version is the same object.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/request/dataset_info.hpp"
#include "server/core/spectrum/sample_bricks.hpp"
#include "server/dataset/prepared_format.hpp"

namespace multitetra {

// The bits of x, y and z taken in turns, x lowest. Requires coordinates of at most 21 bits.
[[nodiscard]] std::uint64_t morton_number(const GridCounts& at);

// Where a brick is.
struct BrickInObject {
  std::size_t object = 0;
  std::uint32_t offset = 0;  // In bytes.
  std::uint32_t size = 0;
};

class SampleObjects {
 public:
  static constexpr std::int32_t kBricks = 8;  // Along an object.
  static constexpr std::int32_t kSamples = kBricks * BrickLayout::kSampleSide;

  SampleObjects(const GridCounts& dims, SampleType type);

  [[nodiscard]] std::size_t size() const { return order_.size(); }  // Objects.
  [[nodiscard]] const BrickLayout& bricks() const { return bricks_; }
  [[nodiscard]] BrickInObject place(std::size_t brick) const;
  // The bricks of an object, in its order.
  [[nodiscard]] std::vector<std::size_t> bricks_of(std::size_t object) const;
  // The object's place among the boxes.
  [[nodiscard]] GridCounts box_of(std::size_t object) const { return boxes_.at(order_[object]); }
  [[nodiscard]] std::size_t object_at(const GridCounts& box) const {
    return rank_[boxes_.index(box)];
  }
  [[nodiscard]] const BrickLayout& boxes() const { return boxes_; }  // Of bricks.
  [[nodiscard]] std::uint32_t bytes_of(std::size_t object) const;

 private:
  // Offsets of bricks in boxes that are cut off in the same way, by their place in the box.
  using Offsets = std::array<std::uint32_t, std::size_t{kBricks} * kBricks * kBricks>;
  [[nodiscard]] std::size_t shape_of(const GridCounts& box) const;

  BrickLayout bricks_;
  BrickLayout boxes_;  // The bricks, in boxes of kBricks.
  std::uint32_t width_;
  std::vector<std::size_t> order_;    // By object: the box.
  std::vector<std::size_t> rank_;     // By box: the object.
  std::array<Offsets, 8> offsets_{};  // By shape: a bit for each axis along which the box is cut.
};

class SpectrumObjects {
 public:
  static constexpr std::uint64_t kSpectrumObjectBytes = std::uint64_t{4} << 20;

  // `index` is that of the section "specidx".
  SpectrumObjects(const DatasetInfo& info, std::span<const BrickPlace> index);

  [[nodiscard]] std::size_t size() const { return begins_.size(); }  // Objects.
  // Requires a brick that is not empty.
  [[nodiscard]] BrickInObject place(std::size_t brick) const { return places_[brick]; }
  [[nodiscard]] std::span<const std::size_t> bricks_of(std::size_t object) const;

 private:
  void add_object(std::size_t begin, std::size_t end, std::span<const BrickPlace> index);

  std::vector<std::size_t> order_;   // Bricks that are not empty, object after object.
  std::vector<std::size_t> begins_;  // By object: where its first brick is in order_.
  std::vector<BrickInObject> places_;
};

}  // namespace multitetra
