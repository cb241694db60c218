#include "server/dataset/brick_layers.hpp"

#include <algorithm>
#include <cstring>
#include <utility>
#include <variant>

#include "common/base/in_parallel.hpp"
#include "server/core/spectrum/prepared_volume.hpp"

namespace multitetra {
namespace {

template <typename Sample>
void copy_brick(const std::vector<Sample>& samples, const BrickLayout& box, const GridCounts& brick,
                std::byte* into) {
  const GridCounts extent = box.extent(brick);
  const std::size_t row_bytes = static_cast<std::size_t>(extent[0]) * sizeof(Sample);
  for (std::int32_t z = 0; z < extent[2]; ++z) {
    for (std::int32_t y = 0; y < extent[1]; ++y, into += row_bytes) {
      const std::ptrdiff_t from = box.side() * brick[0] + std::ptrdiff_t{box.dims()[0]} *
                                                              (box.side() * brick[1] + y +
                                                               std::ptrdiff_t{box.dims()[1]} * z);
      std::memcpy(into, samples.data() + from, row_bytes);
    }
  }
}

}  // namespace

BrickLayers::BrickLayers(const VolumeHeader& header, BrickSink& sink)
    : dims_(header.dims),
      type_(header.type),
      slice_bytes_(header.samples_per_slice() * static_cast<std::size_t>(bytes_per_sample(type_))),
      sink_(sink) {}

void BrickLayers::add(const Samples& slab, std::int32_t slices) {
  const std::int32_t layer_slices = std::min(kSlices, dims_[2] - layer_begin_);
  std::visit(
      [&](const auto& samples) {
        if (slices == layer_slices) {
          add_bricks(samples, BrickLayout({dims_[0], dims_[1], slices}));
          layer_begin_ += slices;
          return;
        }
        if (!scratch_) scratch_ = sink_.new_scratch();
        const std::uint64_t offset = scratch_->put(std::as_bytes(std::span(samples)));
        if (slices_in_layer_ == 0) scratch_begin_ = offset;
        slices_in_layer_ += slices;
      },
      slab);
  if (slices_in_layer_ == layer_slices) flush();
}

void BrickLayers::flush() {
  for (std::int32_t y = 0; y < dims_[1]; y += kSlices) {
    const GridCounts box = {dims_[0], std::min(kSlices, dims_[1] - y), slices_in_layer_};
    visit_type(type_, [&]<typename Sample>(const Sample*) { add_row<Sample>(y, box); });
  }
  layer_begin_ += slices_in_layer_;
  slices_in_layer_ = 0;
  scratch_.reset();
}

template <typename Sample>
void BrickLayers::add_row(std::int32_t y, const GridCounts& box) {
  const std::size_t row = static_cast<std::size_t>(box[0]);
  const std::size_t rows = row * static_cast<std::size_t>(box[1]);
  std::vector<Sample> samples(rows * static_cast<std::size_t>(box[2]));
  std::span<Sample> left(samples);
  for (std::uint64_t z = 0; !left.empty(); ++z, left = left.subspan(rows)) {
    scratch_->get(
        scratch_begin_ + z * slice_bytes_ + static_cast<std::uint64_t>(y) * row * sizeof(Sample),
        std::as_writable_bytes(left.first(rows)));
  }
  add_bricks(samples, BrickLayout(box));
}

template <typename Sample>
void BrickLayers::add_bricks(const std::vector<Sample>& samples, const BrickLayout& box) {
  brick_bytes_.resize(samples.size() * sizeof(Sample));
  in_parallel(static_cast<std::size_t>(box.counts()[1]), [&](std::size_t by) {
    for (std::int32_t bx = 0; bx < box.counts()[0]; ++bx) {
      const GridCounts brick = {bx, static_cast<std::int32_t>(by), 0};
      copy_brick(samples, box, brick, brick_bytes_.data() + box.offset(brick) * sizeof(Sample));
    }
  });
  sink_.add_samples(brick_bytes_);
}

}  // namespace multitetra
