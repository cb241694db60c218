// Sources of field values for the levels of a spectrum: a box of samples, and every eighth sample
// of the whole volume.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "server/core/framework/volume.hpp"
#include "server/core/spectrum/detail/level_wavefront.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/core/spectrum/spectrum_inputs.hpp"

namespace multitetra {

// Values from a box of samples; beyond it, the value outside.
class BoxPlanes : public PlaneSource {
 public:
  explicit BoxPlanes(const DatasetInfo& info) : info_(info), outside_(outside_value(info)) {}

  // Reads the samples first ... first + extent - 1.
  void set(const SampleBoxes& samples, GridPoint first, GridPoint extent) {
    first_ = first;
    extent_ = extent;
    samples.read(first, extent, box_);
  }
  // Removes all samples, for planes that contain none.
  void clear() { extent_ = {}; }

  void read(int exponent, GridPoint low, GridPoint extent, float* into) const override {
    const std::int32_t z = (low.z << exponent) - info_.margin - first_.z;
    if (z < 0 || z >= extent_.z) {
      std::fill_n(into, std::ptrdiff_t{extent.x} * extent.y, outside_);
      return;
    }
    std::visit([&](const auto& samples) { read(samples.data(), z, exponent, low, extent, into); },
               box_);
  }

 private:
  template <typename Sample>
  void read(const Sample* samples, std::int32_t z, int exponent, GridPoint low, GridPoint extent,
            float* into) const {
    const std::int32_t step = 1 << exponent;
    for (std::int32_t j = 0; j < extent.y; ++j, into += extent.x) {
      const std::int32_t y = (low.y + j) * step - info_.margin - first_.y;
      if (y < 0 || y >= extent_.y) {
        std::fill_n(into, extent.x, outside_);
        continue;
      }
      const Sample* const row =
          samples + std::ptrdiff_t{extent_.x} * (y + std::ptrdiff_t{extent_.y} * z);
      for (std::int32_t i = 0; i < extent.x; ++i) {
        const std::int32_t x = (low.x + i) * step - info_.margin - first_.x;
        into[i] = x < 0 || x >= extent_.x ? outside_ : static_cast<float>(row[x]);
      }
    }
  }

  const DatasetInfo& info_;
  GridPoint first_;
  GridPoint extent_;
  Samples box_;
  float outside_;
};

// Every eighth sample of the data, written to the scratch slice by slice.
class CoarseVolume : public PlaneSource {
 public:
  // The scratch must outlive this object and have no other writer.
  CoarseVolume(const DatasetInfo& info, Scratch& scratch)
      : info_(info), extent_(coarse_extent(info)), scratch_(scratch) {}

  // Adds the next slices.
  void add(const Samples& slab, std::int32_t slices) {
    const std::int32_t first = next_slice_;
    next_slice_ += slices;
    for (std::int32_t k = 0; k < extent_.extent.z; ++k) {
      const std::int32_t slice = kSpectrumSpacing * (extent_.low.z + k) - info_.margin - first;
      if (slice < 0 || slice >= slices) continue;
      std::visit([&](const auto& samples) { put_slice(samples, slice); }, slab);
    }
  }

  void read(int exponent, GridPoint low, GridPoint extent, float* into) const override {
    visit_type(info_.type, [&]<typename Sample>(const Sample*) {
      read<Sample>(1 << (exponent - kSpectrumExponent), low, extent, into);
    });
  }

  // Returns the size of all samples. After the last slice they are at the beginning of the scratch,
  // in the format of PreparedVolume::coarse.
  [[nodiscard]] std::uint64_t bytes() const {
    return extent_.size() * static_cast<std::uint64_t>(bytes_per_sample(info_.type));
  }

 private:
  template <typename Sample>
  void put_slice(const std::vector<Sample>& slab, std::int32_t slice) const {
    std::vector<Sample> layer;
    for (std::int32_t j = 0; j < extent_.extent.y; ++j) {
      for (std::int32_t i = 0; i < extent_.extent.x; ++i) {
        const std::int32_t x = kSpectrumSpacing * (extent_.low.x + i) - info_.margin;
        const std::int32_t y = kSpectrumSpacing * (extent_.low.y + j) - info_.margin;
        layer.push_back(slab[static_cast<std::size_t>(
            x + std::ptrdiff_t{info_.dims[0]} * (y + std::ptrdiff_t{info_.dims[1]} * slice))]);
      }
    }
    (void)scratch_.put(std::as_bytes(std::span(layer)));
  }

  template <typename Sample>
  void read(std::int32_t step, GridPoint low, GridPoint extent, float* into) const {
    const float outside = outside_value(info_);
    const GridPoint first = step * low;
    const GridPoint end = extent_.low + extent_.extent;
    // The part of a row from the first to the last requested sample.
    const std::int32_t begin_x = std::max(first.x, extent_.low.x);
    const std::int32_t end_x = std::min(first.x + step * (extent.x - 1) + 1, end.x);
    std::vector<Sample> row(static_cast<std::size_t>(std::max(0, end_x - begin_x)));
    for (std::int32_t j = 0; j < extent.y; ++j, into += extent.x) {
      std::fill_n(into, extent.x, outside);
      const GridPoint at = {begin_x, first.y + step * j, first.z};
      if (row.empty() || !extent_.contains(at)) continue;
      scratch_.get(extent_.index(at) * sizeof(Sample), std::as_writable_bytes(std::span(row)));
      for (std::int32_t i = 0; i < extent.x; ++i) {
        const std::int32_t x = first.x + step * i;
        if (x < begin_x || x >= end_x) continue;
        into[i] = static_cast<float>(row[static_cast<std::size_t>(x - begin_x)]);
      }
    }
  }

  const DatasetInfo info_;
  const LevelExtent extent_;
  Scratch& scratch_;
  std::int32_t next_slice_ = 0;
};

}  // namespace multitetra
