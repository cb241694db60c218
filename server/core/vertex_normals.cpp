#include "server/core/vertex_normals.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>

#include "server/core/field.hpp"
#include "server/core/spectrum_layout.hpp"

namespace multitetra {
namespace {

constexpr float kVoid = std::numeric_limits<float>::quiet_NaN();

// A vertex in the unit cell that holds it. Along an axis on which it lies between two unit points
// the cell has `corners` 2, with the weights below; where it lies on one, that corner is the only
// one.
struct Place {
  GridPoint cell;  // The lowest corner, in units.
  std::array<int, 3> corners{};
  std::array<std::array<double, 2>, 3> weights{};
};

// Units of 2^exponent lattice steps.
Place place_of(const LatticePoint& p, int exponent) {
  Place place{.cell = {p.x >> exponent, p.y >> exponent, p.z >> exponent}};
  const double step = 1.0 / static_cast<double>(1 << exponent);
  const std::array<std::int32_t, 3> at = {p.x, p.y, p.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t beyond = at[axis] & ((1 << exponent) - 1);
    place.corners[axis] = beyond == 0 ? 1 : 2;
    place.weights[axis] = {1 - beyond * step, beyond * step};
  }
  return place;
}

// The values at the corners of a cell and one unit around them: those that the differences reach.
class Neighbourhood {
 public:
  // x, y, z = 0 is one unit below the cell's lowest corner.
  static constexpr std::size_t index(int x, int y, int z) {
    return static_cast<std::size_t>(x + kRow * y + kSlice * z);
  }
  static constexpr std::array<std::size_t, 3> kStep = {1, 4, 16};

  // `value(x, y, z)` is asked only for what is needed.
  template <typename Value>
  void fill(const std::array<int, 3>& corners, const Value& value) {
    for (int z = 0; z < corners[2] + 2; ++z) {
      const bool beyond_z = z == 0 || z == corners[2] + 1;
      for (int y = 0; y < corners[1] + 2; ++y) {
        const bool beyond_y = y == 0 || y == corners[1] + 1;
        if (beyond_y && beyond_z) continue;
        const int margin = beyond_y || beyond_z ? 1 : 0;
        for (int x = margin; x < corners[0] + 2 - margin; ++x) {
          values_[index(x, y, z)] = value(x, y, z);
        }
      }
    }
  }

  // The gradient at the vertex, per unit.
  [[nodiscard]] Vec3 gradient(const Place& place) const {
    const Float4 plain = central_gradient(place);
    const float total = plain[0] + plain[1] + plain[2] + plain[3];
    const bool is_finite = total - total == 0;
    return is_finite ? Vec3{static_cast<double>(plain[0]), static_cast<double>(plain[1]),
                            static_cast<double>(plain[2])}
                     : careful_gradient(place);
  }

 private:
  using Float4 = float __attribute__((vector_size(16)));
  static constexpr int kRow = 4;
  static constexpr int kSlice = 16;

  // All axes at once. Not finite where a value is void, and where a difference exceeds a float.
  [[nodiscard]] Float4 central_gradient(const Place& place) const {
    Float4 sum = {};
    for (int z = 0; z < place.corners[2]; ++z) {
      for (int y = 0; y < place.corners[1]; ++y) {
        const double weight_yz = place.weights[1][static_cast<std::size_t>(y)] *
                                 place.weights[2][static_cast<std::size_t>(z)];
        for (int x = 0; x < place.corners[0]; ++x) {
          const float* const v = &values_[index(x + 1, y + 1, z + 1)];
          const auto half_weight =
              static_cast<float>(0.5 * place.weights[0][static_cast<std::size_t>(x)] * weight_yz);
          // A void corner without void neighbours must show as well.
          const float here = v[0] - v[0];
          const Float4 above = {v[1], v[kRow], v[kSlice], here};
          const Float4 below = {v[-1], v[-kRow], v[-kSlice], here};
          sum += half_weight * (above - below);
        }
      }
    }
    return sum;
  }

  [[nodiscard]] Vec3 careful_gradient(const Place& place) const {
    Vec3 sum = {0, 0, 0};
    for (int z = 0; z < place.corners[2]; ++z) {
      for (int y = 0; y < place.corners[1]; ++y) {
        for (int x = 0; x < place.corners[0]; ++x) {
          const std::size_t at = index(x + 1, y + 1, z + 1);
          if (is_void(values_[at])) continue;
          const double weight = place.weights[0][static_cast<std::size_t>(x)] *
                                place.weights[1][static_cast<std::size_t>(y)] *
                                place.weights[2][static_cast<std::size_t>(z)];
          for (std::size_t axis = 0; axis < 3; ++axis) {
            sum[axis] +=
                weight * slope(values_[at - kStep[axis]], values_[at], values_[at + kStep[axis]]);
          }
        }
      }
    }
    return sum;
  }

  static double slope(float below, float here, float above) {
    const auto difference = [](float a, float b) {
      return static_cast<double>(b) - static_cast<double>(a);
    };
    if (!is_void(below) && !is_void(above)) return 0.5 * difference(below, above);
    if (!is_void(above)) return difference(here, above);
    return is_void(below) ? 0 : difference(below, here);
  }

  std::array<float, 64> values_;
};

// What both sources know of the data's place in the grid, in units.
struct Surroundings {
  std::int32_t last = 0;  // Of the grid.
  float outside = kVoid;

  [[nodiscard]] float beyond_data(GridPoint p) const {
    const bool in_grid = std::min({p.x, p.y, p.z}) >= 0 && std::max({p.x, p.y, p.z}) <= last;
    return in_grid ? outside : kVoid;
  }
};

// Values at all grid points, from the bricks of samples around a box. A unit is a grid step.
template <typename Sample>
class BrickValues {
 public:
  // For cells with lowest corners from `low` to `high`.
  BrickValues(const PreparedVolume& volume, GridPoint low, GridPoint high)
      : source_(*volume.samples),
        layout_(volume.info.dims),
        first_(first_sample(volume.info)),
        surroundings_{.last = 1 << volume.info.grid_exponent,
                      .outside = outside_value(volume.info)} {
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      const std::int32_t last_brick = layout_.counts()[i] - 1;
      first_brick_[i] = std::clamp((low[axis] - 1 - first_[axis]) / kSide, 0, last_brick);
      bricks_[i] =
          std::clamp((high[axis] + 2 - first_[axis]) / kSide, 0, last_brick) + 1 - first_brick_[i];
    }
    read_.resize(static_cast<std::size_t>(bricks_[0]) * static_cast<std::size_t>(bricks_[1]) *
                 static_cast<std::size_t>(bricks_[2]));
  }

  void fill(const Place& place, Neighbourhood& values) {
    const GridPoint low = place.cell - first_ - GridPoint{1, 1, 1};  // Sample indices.
    const GridPoint extent = {place.corners[0] + 2, place.corners[1] + 2, place.corners[2] + 2};
    if (is_in_one_brick(low, extent)) {
      const Brick& brick = brick_of(low);
      const Sample* const from = brick.at(low);
      values.fill(place.corners, [&](int x, int y, int z) {
        return static_cast<float>(from[x + brick.row * y + brick.slice * z]);
      });
    } else {
      values.fill(place.corners, [&](int x, int y, int z) {
        return value(low + GridPoint{x, y, z});
      });
    }
  }

 private:
  static constexpr std::int32_t kSide = BrickLayout::kSampleSide;

  struct Brick {
    const Sample* samples = nullptr;
    std::int32_t row = 0;
    std::int32_t slice = 0;

    [[nodiscard]] const Sample* at(GridPoint p) const {
      return samples + (p.x % kSide + row * (p.y % kSide) + slice * (p.z % kSide));
    }
  };

  [[nodiscard]] bool is_in_one_brick(GridPoint low, GridPoint extent) const {
    for (int axis = 0; axis < 3; ++axis) {
      const std::int32_t end = low[axis] + extent[axis];
      if (low[axis] < 0 || end > layout_.dims()[static_cast<std::size_t>(axis)] ||
          low[axis] / kSide != (end - 1) / kSide) {
        return false;
      }
    }
    return true;
  }

  // Requires a sample of the data.
  const Brick& brick_of(GridPoint p) {
    const GridCounts at = {p.x / kSide, p.y / kSide, p.z / kSide};
    Brick& brick = read_[static_cast<std::size_t>(
        (at[0] - first_brick_[0]) +
        std::ptrdiff_t{bricks_[0]} *
            ((at[1] - first_brick_[1]) + std::ptrdiff_t{bricks_[1]} * (at[2] - first_brick_[2])))];
    if (brick.samples == nullptr) {
      const GridCounts extent = layout_.extent(at);
      brick = {.samples = reinterpret_cast<const Sample*>(source_.brick(layout_.index(at)).data()),
               .row = extent[0],
               .slice = extent[0] * extent[1]};
    }
    return brick;
  }

  float value(GridPoint p) {
    const GridCounts& dims = layout_.dims();
    const bool in_data =
        std::min({p.x, p.y, p.z}) >= 0 && p.x < dims[0] && p.y < dims[1] && p.z < dims[2];
    return in_data ? static_cast<float>(*brick_of(p).at(p)) : surroundings_.beyond_data(p + first_);
  }

  const BrickSource& source_;
  BrickLayout layout_;
  GridPoint first_;
  Surroundings surroundings_;
  GridCounts first_brick_{};
  GridCounts bricks_{};
  std::vector<Brick> read_;  // Without samples until they are needed.
};

// Values at multiples of kSpectrumSpacing, which is the unit.
template <typename Sample>
class CoarseValues {
 public:
  explicit CoarseValues(const PreparedVolume& volume)
      : samples_(volume.coarse),
        extent_(coarse_extent(volume.info)),
        surroundings_{.last = (1 << volume.info.grid_exponent) >> kSpectrumExponent,
                      .outside = outside_value(volume.info)} {}

  void fill(const Place& place, Neighbourhood& values) {
    const GridPoint low = place.cell - GridPoint{1, 1, 1};
    values.fill(place.corners, [&](int x, int y, int z) {
      const GridPoint p = low + GridPoint{x, y, z};
      if (!extent_.contains(p)) return surroundings_.beyond_data(p);
      Sample sample;
      std::memcpy(&sample, samples_.data() + sizeof(Sample) * extent_.index(p), sizeof(Sample));
      return static_cast<float>(sample);
    });
  }

 private:
  std::span<const std::byte> samples_;
  LevelExtent extent_;
  Surroundings surroundings_;
};

Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// Gradients per grid step to directions in the world that fall.
class FallingDirections {
 public:
  // The inverse transpose has the cross products of the map's columns as its columns, divided by
  // the determinant. Its size does not matter here, and is brought near 1.
  explicit FallingDirections(const Affine& grid_to_world) {
    const auto& [a, b, c] = grid_to_world.columns;
    columns_ = {cross(b, c), cross(c, a), cross(a, b)};
    double largest = 0;
    for (const Vec3& column : columns_) {
      for (const double entry : column) largest = std::max(largest, std::abs(entry));
    }
    const double scale = (grid_to_world.determinant() < 0 ? 1 : -1) / largest;
    for (Vec3& column : columns_) {
      for (double& entry : column) entry *= scale;
    }
  }

  [[nodiscard]] UnitVector operator()(const Vec3& gradient) const {
    Vec3 n = {0, 0, 0};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t row = 0; row < 3; ++row) n[row] += columns_[axis][row] * gradient[axis];
    }
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > 0 && length < std::numeric_limits<double>::infinity())) return kNoDirection;
    const double scale = 1 / length;
    return {static_cast<float>(n[0] * scale), static_cast<float>(n[1] * scale),
            static_cast<float>(n[2] * scale)};
  }

 private:
  std::array<Vec3, 3> columns_;
};

// Units of 2^exponent lattice steps.
template <typename Values>
std::vector<UnitVector> normals_from(Values values, std::span<const LatticePoint> points,
                                     int exponent, const FallingDirections& falling) {
  std::vector<UnitVector> normals;
  normals.reserve(points.size());
  Neighbourhood around;
  for (const LatticePoint& point : points) {
    const Place place = place_of(point, exponent);
    values.fill(place, around);
    normals.push_back(falling(around.gradient(place)));
  }
  return normals;
}

}  // namespace

std::vector<UnitVector> vertex_normals(const PreparedVolume& volume,
                                       std::span<const LatticePoint> points, int lattice_resolution,
                                       NormalSource source) {
  if (points.empty()) return {};
  const FallingDirections falling(volume.info.index_to_world);
  return visit_type(volume.info.type, [&]<typename Sample>(const Sample*) {
    if (source == NormalSource::kCoarseSamples) {
      return normals_from(CoarseValues<Sample>(volume), points,
                          lattice_resolution + kSpectrumExponent, falling);
    }
    LatticePoint low = points.front();
    LatticePoint high = low;
    for (const LatticePoint& p : points) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const auto cell = [&](const LatticePoint& p) { return place_of(p, lattice_resolution).cell; };
    return normals_from(BrickValues<Sample>(volume, cell(low), cell(high)), points,
                        lattice_resolution, falling);
  });
}

}  // namespace multitetra
