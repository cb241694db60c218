#include "server/core/surface/vertex_normals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/base/vec3.hpp"
#include "server/core/surface/detail/cell_gradient.hpp"
#include "server/core/surface/detail/cell_values.hpp"

namespace multitetra {
namespace {

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
