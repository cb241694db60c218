// Where the levels of a spectrum take the field's values from: a box of samples, and every eighth
// sample of the whole volume.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <variant>
#include <vector>

#include "common/dataset_info.hpp"
#include "server/core/level_wavefront.hpp"
#include "server/core/prepared_volume.hpp"
#include "server/core/sample_boxes.hpp"
#include "server/core/volume.hpp"

namespace multitetra {

// Values from a box of samples; beyond it the value outside.
class BoxPlanes : public PlaneSource {
 public:
  explicit BoxPlanes(const DatasetInfo& info) : info_(info), outside_(outside_value(info)) {}

  // Takes the samples first ... first + extent - 1.
  void set(const SampleBoxes& samples, GridPoint first, GridPoint extent) {
    first_ = first;
    extent_ = extent;
    samples.read(first, extent, box_);
  }
  // There are none where the next planes are.
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

// Every eighth sample of the data.
class CoarseVolume : public PlaneSource {
 public:
  explicit CoarseVolume(const DatasetInfo& info) : info_(info), extent_(coarse_extent(info)) {
    visit_type(info.type, [&]<typename Sample>(const Sample*) {
      samples_ = std::vector<Sample>(extent_.size());
    });
  }

  // Takes what it needs of a slab that begins with slice `first`.
  void add(const Samples& slab, std::int32_t first, std::int32_t slices) {
    std::visit(
        [&](auto& into) {
          const auto& from = std::get<std::decay_t<decltype(into)>>(slab);
          for (std::int32_t k = 0; k < extent_.extent.z; ++k) {
            const GridPoint at = extent_.low + GridPoint{0, 0, k};
            const std::int32_t slice = kSpectrumSpacing * at.z - info_.margin - first;
            if (slice >= 0 && slice < slices) add_slice(from, slice, at, into);
          }
        },
        samples_);
  }

  void read(int exponent, GridPoint low, GridPoint extent, float* into) const override {
    const float outside = outside_value(info_);
    const std::int32_t step = 1 << (exponent - kSpectrumExponent);
    std::visit(
        [&](const auto& samples) {
          for (std::int32_t j = 0; j < extent.y; ++j) {
            for (std::int32_t i = 0; i < extent.x; ++i) {
              const GridPoint p = step * (low + GridPoint{i, j, 0});
              *into++ =
                  extent_.contains(p) ? static_cast<float>(samples[extent_.index(p)]) : outside;
            }
          }
        },
        samples_);
  }

  [[nodiscard]] const Samples& samples() const { return samples_; }

 private:
  template <typename Values>
  void add_slice(const Values& slab, std::int32_t slice, GridPoint first, Values& into) const {
    for (std::int32_t j = 0; j < extent_.extent.y; ++j) {
      for (std::int32_t i = 0; i < extent_.extent.x; ++i) {
        const GridPoint at = first + GridPoint{i, j, 0};
        const GridPoint sample = kSpectrumSpacing * at - GridPoint{info_.margin, info_.margin, 0};
        into[extent_.index(at)] = slab[static_cast<std::size_t>(
            sample.x +
            std::ptrdiff_t{info_.dims[0]} * (sample.y + std::ptrdiff_t{info_.dims[1]} * slice))];
      }
    }
  }

  const DatasetInfo info_;
  LevelExtent extent_;
  Samples samples_;
};

}  // namespace multitetra
