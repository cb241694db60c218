#include "server/volume/detail/resampled_volume.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "server/volume/detail/sample_conversion.hpp"

namespace multitetra {
namespace {

VolumeHeader header_on_grid(VolumeHeader header, const SlicePlaces& places, Resampling resampling) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    header.dims[axis] = static_cast<std::int32_t>(places.dims[axis]);
  if (resampling == Resampling::kLinear) header.type = SampleType::kF32;
  return header;
}

// The two slices around a position along z, and the weight of the second one.
struct Neighbors {
  std::size_t below = 0;
  std::size_t above = 0;
  double weight = 0;
};

Neighbors neighbors_of(double at, const std::vector<double>& slices) {
  const auto behind = std::upper_bound(slices.begin(), slices.end(), at);
  const auto above = std::min(static_cast<std::size_t>(behind - slices.begin()), slices.size() - 1);
  const std::size_t below = above == 0 ? 0 : above - 1;
  const double gap = slices[above] - slices[below];
  double weight = gap > 0 ? std::clamp((at - slices[below]) / gap, 0.0, 1.0) : 0;
  if (weight < 1e-9) weight = 0;
  if (weight > 1 - 1e-9) weight = 1;
  return {.below = below, .above = above, .weight = weight};
}

class ResampledVolume : public VolumeSource {
 public:
  ResampledVolume(std::unique_ptr<VolumeSource> slices, SlicePlaces places, Resampling resampling)
      : slices_(std::move(slices)),
        places_(std::move(places)),
        resampling_(resampling),
        header_(header_on_grid(slices_->header(), places_, resampling)) {}

  [[nodiscard]] const VolumeHeader& header() const override { return header_; }

  void read(std::int32_t first_slice, std::int32_t slices, Samples& into) override {
    assert(first_slice >= 0 && slices >= 1 && first_slice <= header_.dims[2] - slices);
    const std::size_t slice = header_.samples_per_slice();
    resize(into, header_.type, static_cast<std::size_t>(slices) * slice);
    for (std::int32_t i = 0; i < slices; ++i) {
      const Neighbors around = neighbors_of(first_slice + i, places_.at);
      const auto first = static_cast<std::size_t>(i) * slice;
      if (resampling_ == Resampling::kNearest) {
        put_nearest(around.weight < 0.5 ? around.below : around.above, first, into);
      } else {
        const auto out = std::span(std::get<std::vector<float>>(into)).subspan(first, slice);
        if (around.weight < 1) put(around.below, 1 - around.weight, false, out);
        if (around.weight > 0) put(around.above, around.weight, around.weight < 1, out);
      }
    }
  }

  [[nodiscard]] std::string rounding() const override { return slices_->rounding(); }
  [[nodiscard]] const VolumeContents& contents() const override { return slices_->contents(); }

 private:
  struct LoadedSlice {
    std::size_t index = ~std::size_t{0};
    Samples samples = {};
  };

  // Returns a stored slice; keeps the previous one loaded.
  const Samples& loaded(std::size_t index) {
    LoadedSlice& slice = loaded_[index % 2];
    if (slice.index == index) return slice.samples;
    slice.index = ~std::size_t{0};
    slices_->read(static_cast<std::int32_t>(index), 1, slice.samples);
    slice.index = index;
    return slice.samples;
  }

  // Calls use(out, column, row) for each sample of the grid with its place in a stored slice.
  template <typename Use>
  void for_each_place(std::size_t index, const Use& use) const {
    const std::array<double, 2> shift = places_.shift[index];
    std::size_t out = 0;
    for (std::int64_t y = 0; y < places_.dims[1]; ++y) {
      const double row = static_cast<double>(y) - shift[1];
      const double row_begin = shift[0] + places_.row_shift * row;
      for (std::int64_t x = 0; x < places_.dims[0]; ++x, ++out) {
        use(out, static_cast<double>(x) - row_begin, row);
      }
    }
  }

  [[nodiscard]] std::size_t sample_at(double column, double row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(places_.size[0]) +
           static_cast<std::size_t>(column);
  }

  [[nodiscard]] bool is_inside(double column, double row) const {
    return column >= 0 && row >= 0 && column <= static_cast<double>(places_.size[0] - 1) &&
           row <= static_cast<double>(places_.size[1] - 1);
  }

  void put_nearest(std::size_t index, std::size_t first, Samples& into) {
    std::visit(
        [&](const auto& from) {
          auto& to = std::get<std::remove_cvref_t<decltype(from)>>(into);
          for_each_place(index, [&](std::size_t out, double column, double row) {
            const double x = std::round(column);
            const double y = std::round(row);
            to[first + out] = {};
            if (is_inside(x, y)) to[first + out] = from[sample_at(x, y)];
          });
        },
        loaded(index));
  }

  // Adds a weighted slice, or assigns it.
  void put(std::size_t index, double weight, bool adds, std::span<float> to) {
    std::visit(
        [&](const auto& from) {
          for_each_place(index, [&](std::size_t out, double column, double row) {
            const auto value = static_cast<float>(weight * interpolated(from, column, row));
            to[out] = adds ? to[out] + value : value;
          });
        },
        loaded(index));
  }

  template <typename Stored>
  [[nodiscard]] double interpolated(const std::vector<Stored>& from, double column,
                                    double row) const {
    if (!is_inside(column, row)) return std::numeric_limits<double>::quiet_NaN();
    const double x = std::floor(column);
    const double y = std::floor(row);
    const double fx = column - x;
    const double fy = row - y;
    const auto sample = [&](double at_x, double at_y) {
      return static_cast<double>(from[sample_at(at_x, at_y)]);
    };
    // A void sample without weight does not count.
    double value = sample(x, y) * (1 - fx) * (1 - fy);
    if (fx > 0) value += sample(x + 1, y) * fx * (1 - fy);
    if (fy > 0) value += sample(x, y + 1) * (1 - fx) * fy;
    if (fx > 0 && fy > 0) value += sample(x + 1, y + 1) * fx * fy;
    return value;
  }

  std::unique_ptr<VolumeSource> slices_;
  SlicePlaces places_;
  Resampling resampling_;
  VolumeHeader header_;
  std::array<LoadedSlice, 2> loaded_;
};

}  // namespace

std::unique_ptr<VolumeSource> resampled_volume(std::unique_ptr<VolumeSource> slices,
                                               SlicePlaces places, Resampling resampling) {
  return std::make_unique<ResampledVolume>(std::move(slices), std::move(places), resampling);
}

}  // namespace multitetra
