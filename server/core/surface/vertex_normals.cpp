#include "server/core/surface/vertex_normals.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <vector>

#include "common/base/vec3.hpp"
#include "server/core/spectrum/prepared_volume.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/core/surface/detail/cell_gradient.hpp"

namespace multitetra {
namespace {

// ---- the values around the cells of vertices, from bricks of samples or from the coarse samples

// Outside the grid they are void; between the data and the grid's end, the value outside.
// Holds the position of the data in the grid, in units.
struct DataSurroundings {
  std::int32_t last = 0;  // Largest coordinate of the grid.
  float outside = std::numeric_limits<float>::quiet_NaN();

  [[nodiscard]] float beyond_data(GridPoint p) const {
    const bool in_grid = std::min({p.x, p.y, p.z}) >= 0 && std::max({p.x, p.y, p.z}) <= last;
    return in_grid ? outside : std::numeric_limits<float>::quiet_NaN();
  }
};

// Values at all grid points, from the bricks of samples around a box. The unit is a grid step.
template <typename Sample>
class BrickValues {
 public:
  // Serves cells with lowest corners from `low` to `high`.
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

  void fill(const PlaceInCell& place, CellNeighbourhood& values) {
    const GridPoint low = place.cell - first_ - GridPoint{1, 1, 1};  // In sample indices.
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
    RetainedBytes bytes;
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
      brick = {.bytes = source_.brick(layout_.index(at)),
               .row = extent[0],
               .slice = extent[0] * extent[1]};
      brick.samples = reinterpret_cast<const Sample*>(brick.bytes.data());
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
  DataSurroundings surroundings_;
  GridCounts first_brick_{};
  GridCounts bricks_{};
  // `samples` is null until the brick is read.
  std::vector<Brick> read_;
};

// Values at multiples of kSpectrumSpacing, which is the unit.
template <typename Sample>
class CoarseValues {
 public:
  explicit CoarseValues(const PreparedVolume& volume)
      : samples_(volume.coarse.bytes()),
        extent_(coarse_extent(volume.info)),
        surroundings_{.last = (1 << volume.info.grid_exponent) >> kSpectrumExponent,
                      .outside = outside_value(volume.info)} {}

  void fill(const PlaceInCell& place, CellNeighbourhood& values) {
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
  DataSurroundings surroundings_;
};

// Maps gradients per grid step to descent directions in the world.
class DescentDirections {
 public:
  // The columns of the inverse transpose are the cross products of the map's columns divided by the
  // determinant. Their magnitude is irrelevant and scaled to about 1.
  explicit DescentDirections(const Affine& grid_to_world) {
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

// Cells have a side of 2^exponent lattice steps.
template <typename Values>
std::vector<UnitVector> normals_from(Values values, std::span<const LatticePoint> points,
                                     int exponent, const DescentDirections& falling) {
  std::vector<UnitVector> normals;
  normals.reserve(points.size());
  CellNeighbourhood around;
  for (const LatticePoint& point : points) {
    const PlaceInCell place = place_of(point, exponent);
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
  const DescentDirections falling(volume.info.index_to_world);
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
