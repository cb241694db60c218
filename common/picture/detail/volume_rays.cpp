#include "common/picture/detail/volume_rays.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace multitetra {
namespace {

constexpr std::size_t kEntries = 1024;
constexpr double kMostOpaque = 0.9999;       // Its logarithm is finite.
constexpr double kNarrow = 1e-6;             // A range for a single value, as a part of it.
constexpr std::size_t kBlockCells = 8;       // Per side.
constexpr float kOpaqueEnough = 1.0F / 256;  // What still passes cannot be seen.
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

double opacity_at(const std::vector<OpacityPoint>& points, double value) {
  const auto next =
      std::find_if(points.begin(), points.end(), [&](const auto& p) { return p.value > value; });
  if (next == points.begin()) return points.front().opacity;
  if (next == points.end()) return points.back().opacity;
  const OpacityPoint& from = *(next - 1);
  const double part = (value - from.value) / (next->value - from.value);
  return from.opacity + part * (next->opacity - from.opacity);
}

}  // namespace

ExtinctionTable::ExtinctionTable(const std::vector<OpacityPoint>& points)
    : first_(points.front().value), entries_(kEntries) {
  const double range = points.back().value - first_;
  spacing_ = (range > 0 ? range : kNarrow * std::max(1.0, std::abs(first_))) / (kEntries - 1);
  for (std::size_t i = 0; i < kEntries; ++i) {
    const double value = first_ + static_cast<double>(i) * spacing_;
    // A step at the first value comes after it.
    const double opacity = i == 0 ? points.front().opacity : opacity_at(points, value);
    entries_[i].extinction = -std::log(1 - std::min(opacity, kMostOpaque));
    if (i == 0) continue;
    const Entry& before = entries_[i - 1];
    entries_[i].integral =
        before.integral + 0.5 * spacing_ * (before.extinction + entries_[i].extinction);
  }
}

ExtinctionTable::Entry ExtinctionTable::at(double value) const {
  const double place = (value - first_) / spacing_;
  const double last = kEntries - 1;
  const auto before = static_cast<std::size_t>(std::clamp(place, 0.0, last - 1));
  const double part = std::clamp(place - static_cast<double>(before), 0.0, 1.0);
  const Entry& one = entries_[before];
  const Entry& next = entries_[before + 1];
  Entry found{.extinction = one.extinction + part * (next.extinction - one.extinction),
              .integral = one.integral + part * (next.integral - one.integral)};
  found.integral += found.extinction * spacing_ * (place - std::clamp(place, 0.0, last));
  return found;
}

double ExtinctionTable::mean(double one, double other) const {
  const Entry a = at(one);
  const Entry b = at(other);
  const double apart = other - one;
  const bool is_far = std::abs(apart) > spacing_;
  return std::max(0.0,
                  is_far ? (b.integral - a.integral) / apart : 0.5 * (a.extinction + b.extinction));
}

Mix VolumeRay::up_to(double depth) const {
  const double place =
      std::clamp((depth - first_) / spacing_, 0.0, static_cast<double>(sums_.size()) - 1);
  const auto before = static_cast<std::size_t>(place);
  Mix mix = sums_[before];
  if (before + 1 == sums_.size()) return mix;
  const auto part = static_cast<float>(place - static_cast<double>(before));
  const Mix& next = sums_[before + 1];
  for (std::size_t j = 0; j < 3; ++j) mix.light[j] += part * (next.light[j] - mix.light[j]);
  mix.passing += part * (next.passing - mix.passing);
  return mix;
}

Mix VolumeRay::largest_between(double near, double far) const {
  const auto count = static_cast<double>(values_.size());
  const auto from =
      static_cast<std::size_t>(std::clamp(std::ceil((near - first_) / spacing_), 0.0, count));
  const auto to =
      static_cast<std::size_t>(std::clamp(std::floor((far - first_) / spacing_) + 1, 0.0, count));
  float largest = kNone;
  for (std::size_t i = from; i < to; ++i) {
    if (!(values_[i] <= largest) && !std::isnan(values_[i])) largest = values_[i];
  }
  if (std::isnan(largest)) return {};
  return {.light = linear_light(volume_->colors(largest)), .passing = 0};
}

Mix VolumeRay::between(double near, double far) const {
  if (volume_->is_maximum) return largest_between(near, far);
  if (sums_.empty()) return {};
  const Mix before = up_to(near);
  const Mix all = up_to(far);
  if (before.passing < kOpaqueEnough) return {};
  Mix mix{.light = {}, .passing = all.passing / before.passing};
  for (std::size_t j = 0; j < 3; ++j)
    mix.light[j] = (all.light[j] - before.light[j]) / before.passing;
  return mix;
}

VolumeRays::VolumeRays(const DrawnVolume& volume, const Camera& camera)
    : volume_(volume),
      camera_(camera),
      to_index_(inverse(volume.to_world)),
      extinctions_(volume.is_maximum ? std::vector<OpacityPoint>{{}} : volume.opacities) {
  assert(volume.values.size() == volume.counts[0] * volume.counts[1] * volume.counts[2]);
  measure_blocks();
}

void VolumeRays::measure_blocks() {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    block_counts_[axis] = (volume_.counts[axis] - 2) / kBlockCells + 1;
  }
  const auto [nx, ny, nz] = volume_.counts;
  for (std::size_t bz = 0; bz < block_counts_[2]; ++bz) {
    for (std::size_t by = 0; by < block_counts_[1]; ++by) {
      for (std::size_t bx = 0; bx < block_counts_[0]; ++bx) {
        Block block{.low = std::numeric_limits<float>::infinity(),
                    .high = -std::numeric_limits<float>::infinity()};
        const auto end = [](std::size_t b, std::size_t n) {
          return std::min((b + 1) * kBlockCells + 1, n);
        };
        for (std::size_t z = bz * kBlockCells; z < end(bz, nz); ++z) {
          for (std::size_t y = by * kBlockCells; y < end(by, ny); ++y) {
            for (std::size_t x = bx * kBlockCells; x < end(bx, nx); ++x) {
              const float value = volume_.values[(z * ny + y) * nx + x];
              block.low = std::fmin(block.low, value);
              block.high = std::fmax(block.high, value);
            }
          }
        }
        block.is_visible = block.low <= block.high &&
                           (volume_.is_maximum || extinctions_.mean(block.low, block.high) > 0);
        blocks_.push_back(block);
      }
    }
  }
}

float VolumeRays::value_at(const Vec3& index) const {
  std::array<std::size_t, 3> cell{};
  std::array<float, 3> part{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double last = static_cast<double>(volume_.counts[axis]) - 1;
    const double place = std::clamp(index[axis], 0.0, last);
    cell[axis] = std::min(static_cast<std::size_t>(place), volume_.counts[axis] - 2);
    part[axis] = static_cast<float>(place - static_cast<double>(cell[axis]));
  }
  const std::size_t row = volume_.counts[0];
  const std::size_t layer = row * volume_.counts[1];
  const float* const at = &volume_.values[cell[2] * layer + cell[1] * row + cell[0]];
  const auto along_x = [&](const float* a) { return a[0] + part[0] * (a[1] - a[0]); };
  const auto along_y = [&](const float* a) {
    const float low = along_x(a);
    return low + part[1] * (along_x(a + row) - low);
  };
  const float low = along_y(at);
  return low + part[2] * (along_y(at + layer) - low);
}

// `first`: the block's first sample.
const VolumeRays::Block& VolumeRays::block_at(const Vec3& index, Vec3& first) const {
  std::size_t number = 0;
  for (std::size_t axis = 3; axis-- > 0;) {
    const double last = static_cast<double>(block_counts_[axis]) - 1;
    const double block = std::clamp(std::floor(index[axis] / kBlockCells), 0.0, last);
    first[axis] = block * kBlockCells;
    number = number * block_counts_[axis] + static_cast<std::size_t>(block);
  }
  return blocks_[number];
}

// Returns the light of a place with this value: its color, lit from the eye. `direction`: of the
// ray.
Light VolumeRays::light_at(const Vec3& index, double value, const Vec3& direction) const {
  Light light = linear_light(volume_.colors(value));
  if (!volume_.is_lit) return light;
  Vec3 gradient = {0, 0, 0};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vec3 before = index;
    Vec3 after = index;
    before[axis] -= 1;
    after[axis] += 1;
    const double slope = value_at(after) - value_at(before);
    if (std::isnan(slope)) return light;
    // The gradient in the world: the rows of the map to indices.
    for (std::size_t i = 0; i < 3; ++i) gradient[i] += slope * to_index_.columns[i][axis];
  }
  const double steepness = length(gradient);
  if (steepness == 0) return light;
  const double facing = std::abs(dot(gradient, direction)) / (steepness * length(direction));
  const double shine = 0.18 * std::pow(facing, 24);
  for (float& part : light) part = static_cast<float>(part * (0.3 + 0.75 * facing) + shine);
  return light;
}

void VolumeRays::trace(int x, int y, VolumeRay& ray) const {
  ray.volume_ = &volume_;
  ray.sums_.clear();
  ray.values_.clear();
  // The place at depth d is the eye + d * direction.
  const double right = (x + 0.5 - camera_.width / 2.0) / camera_.pixels_at_one;
  const double up = (camera_.height / 2.0 - y - 0.5) / camera_.pixels_at_one;
  const Vec3 direction =
      difference(sum(scaled(camera_.right, right), scaled(camera_.up, up)), camera_.back);
  const Vec3 eye = to_index_(camera_.eye);
  const Vec3 way = difference(to_index_(sum(camera_.eye, direction)), eye);
  double enter = 0;
  double leave = std::numeric_limits<double>::infinity();
  double fastest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double last = static_cast<double>(volume_.counts[axis]) - 1;
    fastest = std::max(fastest, std::abs(way[axis]));
    if (way[axis] == 0 && (eye[axis] < 0 || eye[axis] > last)) return;
    if (way[axis] == 0) continue;
    const auto [near, far] = std::minmax({-eye[axis] / way[axis], (last - eye[axis]) / way[axis]});
    enter = std::max(enter, near);
    leave = std::min(leave, far);
  }
  if (!(enter < leave)) return;
  ray.first_ = enter;
  // Along the axis of most samples: the largest value is at a sample, light comes from between
  // them.
  ray.spacing_ = (volume_.is_maximum ? 1 : 0.5) / fastest;
  const auto count = static_cast<std::size_t>((leave - enter) / ray.spacing_) + 1;
  const double thickness = ray.spacing_ * length(direction) / volume_.voxel;
  if (!volume_.is_maximum) ray.sums_.push_back({});
  Mix mix;
  float value = kNone;
  bool is_value_known = false;  // Of the place before.
  const auto place_at = [&](double number) {
    return moved(eye, enter + number * ray.spacing_, way);
  };
  // Extends the ray to places where nothing is added.
  const auto skip_to = [&](std::size_t end) {
    if (volume_.is_maximum) {
      ray.values_.resize(end, kNone);
    } else {
      ray.sums_.resize(end, mix);
    }
    is_value_known = false;
  };
  for (std::size_t i = volume_.is_maximum ? 0 : 1; i < count;) {
    const Vec3 place = place_at(static_cast<double>(i));
    Vec3 corner{};
    const Block& block = block_at(place, corner);
    double until = leave;  // Where the ray leaves the block.
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (way[axis] == 0) continue;
      const double side = corner[axis] + (way[axis] > 0 ? kBlockCells : 0);
      until = std::min(until, std::max(0.0, (side - eye[axis]) / way[axis]));
    }
    const auto end = std::clamp(
        static_cast<std::size_t>(std::max(0.0, until - enter) / ray.spacing_) + 1, i + 1, count);
    if (!block.is_visible) {
      skip_to(end);
      i = end;
      continue;
    }
    if (!volume_.is_maximum && !is_value_known)
      value = value_at(place_at(static_cast<double>(i) - 1));
    for (; i < end; ++i) {
      const float before = value;
      value = value_at(place_at(static_cast<double>(i)));
      if (volume_.is_maximum) {
        ray.values_.push_back(value);
        continue;
      }
      const float from = std::isnan(before) ? value : before;
      const double mean = std::isnan(value) ? 0 : extinctions_.mean(from, value);
      if (mean > 0) {
        const double middle = 0.5 * (from + value);
        const Light light = light_at(place_at(static_cast<double>(i) - 0.5), middle, direction);
        const auto part = static_cast<float>(mix.passing * (1 - std::exp(-mean * thickness)));
        for (std::size_t j = 0; j < 3; ++j) mix.light[j] += part * light[j];
        mix.passing -= part;
      }
      ray.sums_.push_back(mix);
      if (mix.passing < kOpaqueEnough) return;
    }
    is_value_known = true;
  }
}

}  // namespace multitetra
