#include "server/dataset/detail/brick_layers.hpp"

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

// ---- BrickAssembler

std::span<const std::byte> BrickAssembler::bricks(const Samples& box, const GridCounts& dims) {
  std::visit([&](const auto& samples) { rearrange(samples, BrickLayout(dims)); }, box);
  return bytes_;
}

template <typename Sample>
void BrickAssembler::rearrange(const std::vector<Sample>& samples, const BrickLayout& box) {
  bytes_.resize(samples.size() * sizeof(Sample));
  in_parallel(static_cast<std::size_t>(box.counts()[1]), [&](std::size_t by) {
    for (std::int32_t bx = 0; bx < box.counts()[0]; ++bx) {
      const GridCounts brick = {bx, static_cast<std::int32_t>(by), 0};
      copy_brick(samples, box, brick, bytes_.data() + box.offset(brick) * sizeof(Sample));
    }
  });
}

// ---- BrickLayers

BrickLayers::BrickLayers(const VolumeHeader& header, PreparedSink& sink)
    : dims_(header.dims),
      type_(header.type),
      slice_bytes_(header.samples_per_slice() * static_cast<std::size_t>(bytes_per_sample(type_))),
      sink_(sink) {}

void BrickLayers::add(const Samples& slab, std::int32_t slices) {
  const std::int32_t layer_slices = std::min(kSlices, dims_[2] - layer_begin_);
  if (slices == layer_slices) {
    sink_.add_samples(brick_assembler_.bricks(slab, {dims_[0], dims_[1], slices}));
    layer_begin_ += slices;
    return;
  }
  if (!scratch_) scratch_ = sink_.new_scratch();
  std::visit(
      [&](const auto& samples) {
        buffered_offsets_.push_back(scratch_->put(std::as_bytes(std::span(samples))));
      },
      slab);
  buffered_slices_.push_back(slices);
  slices_in_layer_ += slices;
  if (slices_in_layer_ == layer_slices) flush();
}

void BrickLayers::flush() {
  for (std::int32_t y = 0; y < dims_[1]; y += kSlices) {
    const GridCounts box = {dims_[0], std::min(kSlices, dims_[1] - y), slices_in_layer_};
    visit_type(type_, [&]<typename Sample>(const Sample*) { add_row<Sample>(y, box); });
  }
  layer_begin_ += slices_in_layer_;
  slices_in_layer_ = 0;
  buffered_offsets_.clear();
  buffered_slices_.clear();
  scratch_.reset();
}

template <typename Sample>
void BrickLayers::add_row(std::int32_t y, const GridCounts& box) {
  const std::size_t row = static_cast<std::size_t>(box[0]);
  const std::size_t rows = row * static_cast<std::size_t>(box[1]);
  std::vector<Sample> samples(rows * static_cast<std::size_t>(box[2]));
  std::span<Sample> left(samples);
  for (std::size_t i = 0; i < buffered_offsets_.size(); ++i) {
    for (std::int32_t z = 0; z < buffered_slices_[i]; ++z, left = left.subspan(rows)) {
      scratch_->get(buffered_offsets_[i] + static_cast<std::uint64_t>(z) * slice_bytes_ +
                        static_cast<std::uint64_t>(y) * row * sizeof(Sample),
                    std::as_writable_bytes(left.first(rows)));
    }
  }
  row_ = std::move(samples);
  sink_.add_samples(brick_assembler_.bricks(row_, box));
}

}  // namespace multitetra
