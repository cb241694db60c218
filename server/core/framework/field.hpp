// The scalar field of the framework: a volume placed in the grid, and the values outside of it.
//
// A value is a float; NaN means void, a place without a value. Beyond the data the field is either
// void or has one constant value.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <variant>

#include "common/dataset/dataset_info.hpp"
#include "server/core/framework/grid.hpp"
#include "server/core/framework/volume.hpp"

namespace multitetra {

[[nodiscard]] inline bool is_void(float value) { return value != value; }

// A view of the field with one sample type. The volume must outlive it.
template <typename Sample>
class SampledField {
 public:
  SampledField(const Volume& volume, const std::vector<Sample>& samples, std::int32_t margin,
               float outside)
      : samples_(samples.data()),
        dims_(volume.dims),
        margin_(margin),
        outside_(outside),
        row_(volume.dims[0]),
        slice_(static_cast<std::ptrdiff_t>(volume.dims[0]) * volume.dims[1]) {}

  // Returns the value at any point, inside or outside the data.
  [[nodiscard]] float at(GridPoint p) const {
    const std::int32_t x = p.x - margin_;
    const std::int32_t y = p.y - margin_;
    const std::int32_t z = p.z - margin_;
    if (x < 0 || y < 0 || z < 0 || x >= dims_[0] || y >= dims_[1] || z >= dims_[2]) return outside_;
    return static_cast<float>(samples_[x + row_ * y + slice_ * z]);
  }

  // Returns whether the points p + step * offset have values on different sides of c or include
  // void. `offsets` have coordinates -1, 0 and 1.
  template <typename Offsets>
  [[nodiscard]] bool is_mixed(GridPoint p, std::int32_t step, const Offsets& offsets,
                              double c) const {
    const GridPoint i = p - GridPoint{margin_, margin_, margin_};
    const bool is_inside = i.x >= step && i.y >= step && i.z >= step && i.x + step < dims_[0] &&
                           i.y + step < dims_[1] && i.z + step < dims_[2];
    int positive = 0;
    int negative = 0;
    if (is_inside) {
      const Sample* center = samples_ + (i.x + row_ * i.y + slice_ * i.z);
      for (const GridPoint offset : offsets) {
        const auto value =
            static_cast<double>(center[step * (offset.x + row_ * offset.y + slice_ * offset.z)]);
        positive += value > c ? 1 : 0;
        negative += value <= c ? 1 : 0;
      }
    } else {
      for (const GridPoint offset : offsets) {
        const auto value = static_cast<double>(at(p + step * offset));
        positive += value > c ? 1 : 0;
        negative += value <= c ? 1 : 0;
      }
    }
    const auto count = static_cast<int>(offsets.size());
    return positive != count && negative != count;
  }

 private:
  const Sample* samples_;
  std::array<std::int32_t, 3> dims_;
  std::int32_t margin_;
  float outside_;
  std::ptrdiff_t row_;
  std::ptrdiff_t slice_;
};

class Field {
 public:
  // The volume must outlive the field.
  Field(const Volume& volume, std::optional<double> outside, std::int32_t margin)
      : volume_(&volume),
        outside_(outside ? static_cast<float>(*outside) : std::numeric_limits<float>::quiet_NaN()),
        margin_(margin),
        grid_(grid_exponent_for(volume.dims, margin)) {}

  [[nodiscard]] const Grid& grid() const { return grid_; }
  [[nodiscard]] const Vec3& spacing() const { return volume_->spacing; }

  // Return the data's first and last sample.
  [[nodiscard]] GridPoint first_sample() const { return {margin_, margin_, margin_}; }
  [[nodiscard]] GridPoint last_sample() const {
    return first_sample() +
           GridPoint{volume_->dims[0] - 1, volume_->dims[1] - 1, volume_->dims[2] - 1};
  }

  // Calls `visitor` with the SampledField of the stored type: one dispatch for a whole pass.
  template <typename Visitor>
  decltype(auto) visit(Visitor&& visitor) const {
    return std::visit(
        [&](const auto& samples) -> decltype(auto) {
          return visitor(SampledField(*volume_, samples, margin_, outside_));
        },
        volume_->samples);
  }

 private:
  const Volume* volume_;
  float outside_;
  std::int32_t margin_;
  Grid grid_;
};

}  // namespace multitetra
