#include "server/volume/generators/head_phantom.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "common/base/exact_sine.hpp"

namespace multitetra {
namespace {

constexpr double kAir = -1000;

struct Row {
  double value;  // Hounsfield units, added to those of the enclosing ellipsoids.
  std::array<double, 3> center;
  std::array<double, 3> semi_axes;
  double degrees;  // Rotation about z.
};

constexpr std::array<Row, 10> kTable = {{
    {2000, {0, 0, 0}, {0.69, 0.92, 0.9}, 0},                // skull
    {-800, {0, 0, 0}, {0.6624, 0.874, 0.88}, 0},            // brain
    {-200, {-0.22, 0, -0.25}, {0.41, 0.16, 0.21}, 108},     // ventricles
    {-200, {0.22, 0, -0.25}, {0.31, 0.11, 0.22}, 72},       //
    {100, {0, 0.35, -0.25}, {0.21, 0.25, 0.5}, 0},          // tumors
    {100, {0, 0.1, -0.25}, {0.046, 0.046, 0.046}, 0},       //
    {100, {-0.08, -0.65, -0.25}, {0.046, 0.023, 0.02}, 0},  //
    {100, {0.06, -0.65, -0.25}, {0.046, 0.023, 0.02}, 90},  //
    {100, {0.06, -0.105, 0.625}, {0.056, 0.04, 0.1}, 90},   //
    {-200, {0, 0.1, 0.625}, {0.056, 0.04, 0.1}, 0},         // a fluid-filled cyst
}};

// Returns the fraction of a voxel inside the surface f = 0, where f < 0 is inside. Linear in the
// distance, which is f / |gradient| to first order.
double coverage(double f, double squared_gradient, double voxel) {
  const double half = voxel / 2;
  if (f * f >= half * half * squared_gradient) return f < 0 ? 1 : 0;
  return 0.5 - f / (std::sqrt(squared_gradient) * voxel);
}

}  // namespace

HeadPhantom::HeadPhantom(std::int32_t size) : size_(size), voxel_(2 / (size_ - 1)) {
  std::transform(kTable.begin(), kTable.end(), ellipsoids_.begin(), [this](const Row& row) {
    const double c = cosine_of_turns(row.degrees / 360);
    const double s = sine_of_turns(row.degrees / 360);
    const auto& [a, b, height] = row.semi_axes;
    return Ellipsoid{
        .value = row.value,
        .inverse_axes = {1 / a, 1 / b, 1 / height},
        .center = row.center,
        .cosine = c,
        .sine = s,
        .half_extents = {std::sqrt(a * a * c * c + b * b * s * s) + voxel_,
                         std::sqrt(a * a * s * s + b * b * c * c) + voxel_, height + voxel_}};
  });
}

void HeadPhantom::fill_row(std::int32_t y, std::int32_t z, std::span<double> row) const {
  std::fill(row.begin(), row.end(), kAir);
  for (const Ellipsoid& ellipsoid : ellipsoids_) {
    add(ellipsoid, y * voxel_ - 1, z * voxel_ - 1, row);
  }
}

void HeadPhantom::add(const Ellipsoid& e, double y, double z, std::span<double> row) const {
  const double dy = y - e.center[1];
  const double dz = z - e.center[2];
  if (std::abs(dy) > e.half_extents[1] || std::abs(dz) > e.half_extents[2]) return;
  const auto column = [this](double x) {
    return static_cast<std::size_t>(std::clamp((x + 1) / voxel_, 0.0, size_));
  };
  const std::size_t begin = column(e.center[0] - e.half_extents[0]);
  const std::size_t end = std::min(row.size(), column(e.center[0] + e.half_extents[0]) + 1);
  const auto& [a, b, c] = e.inverse_axes;
  const double w = dz * c;
  for (std::size_t i = begin; i < end; ++i) {
    const double dx = static_cast<double>(i) * voxel_ - 1 - e.center[0];
    const double u = (dx * e.cosine + dy * e.sine) * a;
    const double v = (dy * e.cosine - dx * e.sine) * b;
    const double f = u * u + v * v + w * w - 1;
    const double squared_gradient = 4 * (u * u * (a * a) + v * v * (b * b) + w * w * (c * c));
    row[i] += e.value * coverage(f, squared_gradient, voxel_);
  }
}

}  // namespace multitetra
