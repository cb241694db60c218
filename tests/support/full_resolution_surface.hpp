// The isosurface of a volume at full resolution, computed from the definition, independently of the
// server, to verify it.
//
// The finest tetrahedra of the framework: for each cube of side 2 whose center d has odd grid
// coordinates, each of its six face centers f, each of the four edge midpoints m of that face, and
// each end k of that edge, there is the tetrahedron (d, f, m, k). A cube has 48, and all cubes
// together have 6 n^3. A sample is positive if it is greater than the isovalue. In a tetrahedron
// the field is linear and its isosurface a triangle or a plane quadrangle; a tetrahedron with a
// void corner has none. Vertices are exact crossings, not snapped to the lattice.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "common/mesh/surface_distance.hpp"

namespace multitetra::testing {

// The 27 points of a cube of side 2, numbered x + 3 y + 9 z with x, y, z from 0 to 2.
inline constexpr std::size_t kPoints = 27;
inline constexpr int number_of(const std::array<int, 3>& p) { return p[0] + 3 * p[1] + 9 * p[2]; }

using Corners = std::array<int, 4>;

inline constexpr std::array<Corners, 48> tetrahedra_of_cube() {
  std::array<Corners, 48> tetrahedra{};
  std::size_t count = 0;
  for (std::size_t normal = 0; normal < 3; ++normal) {
    for (std::size_t across = 0; across < 3; ++across) {
      if (across == normal) continue;
      const std::size_t along = 3 - normal - across;
      for (int bits = 0; bits < 8; ++bits) {
        const std::array<int, 3> d = {1, 1, 1};
        std::array<int, 3> f = d;
        f[normal] += (bits & 1) != 0 ? 1 : -1;
        std::array<int, 3> m = f;
        m[across] += (bits & 2) != 0 ? 1 : -1;
        std::array<int, 3> k = m;
        k[along] += (bits & 4) != 0 ? 1 : -1;
        tetrahedra[count++] = {number_of(d), number_of(f), number_of(m), number_of(k)};
      }
    }
  }
  return tetrahedra;
}
inline constexpr std::array<Corners, 48> kTetrahedra = tetrahedra_of_cube();

// The field on the grid: samples, and one value beyond them (NaN: void).
class GridField {
 public:
  GridField(const DatasetInfo& info, std::span<const float> samples)
      : info_(info),
        samples_(samples),
        outside_(info.outside ? static_cast<float>(*info.outside)
                              : std::numeric_limits<float>::quiet_NaN()) {}

  [[nodiscard]] double at(std::array<std::int32_t, 3> p) const {
    std::size_t index = 0;
    for (std::size_t axis = 3; axis-- > 0;) {
      const std::int32_t i = p[axis] - info_.margin;
      if (i < 0 || i >= info_.dims[axis]) return outside_;
      index = index * static_cast<std::size_t>(info_.dims[axis]) + static_cast<std::size_t>(i);
    }
    return static_cast<double>(samples_[index]);
  }

 private:
  const DatasetInfo& info_;
  std::span<const float> samples_;
  float outside_;
};

struct Cube {
  std::array<Vec3, kPoints> places;  // World.
  std::array<double, kPoints> values;
};

inline Vec3 crossing(const Cube& cube, int a, int b, double isovalue) {
  const auto i = static_cast<std::size_t>(a);
  const auto j = static_cast<std::size_t>(b);
  const double t = (isovalue - cube.values[i]) / (cube.values[j] - cube.values[i]);
  Vec3 place;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    place[axis] = cube.places[i][axis] + t * (cube.places[j][axis] - cube.places[i][axis]);
  }
  return place;
}

inline void add_surface(const Cube& cube, const Corners& tetrahedron, double isovalue,
                        std::vector<SurfaceTriangle>& surface) {
  Corners corners{};  // Positive corners first.
  std::size_t positive = 0;
  std::size_t negative = 0;
  for (const int corner : tetrahedron) {
    const double value = cube.values[static_cast<std::size_t>(corner)];
    if (std::isnan(value)) return;
    if (value > isovalue) {
      corners[positive++] = corner;
    } else {
      corners[3 - negative++] = corner;
    }
  }
  if (positive == 0 || negative == 0) return;
  const auto cut = [&](std::size_t a, std::size_t b) {
    return crossing(cube, corners[a], corners[b], isovalue);
  };
  if (positive == 2) {
    const std::array<Vec3, 4> quadrangle = {cut(0, 2), cut(0, 3), cut(1, 3), cut(1, 2)};
    surface.push_back({quadrangle[0], quadrangle[1], quadrangle[2]});
    surface.push_back({quadrangle[0], quadrangle[2], quadrangle[3]});
  } else if (positive == 1) {
    surface.push_back({cut(0, 1), cut(0, 2), cut(0, 3)});
  } else {
    surface.push_back({cut(3, 0), cut(3, 1), cut(3, 2)});
  }
}

inline bool is_crossed(const std::array<double, kPoints>& values, double isovalue) {
  const auto positive = std::count_if(values.begin(), values.end(),
                                      [isovalue](double value) { return value > isovalue; });
  const auto negative = std::count_if(values.begin(), values.end(),
                                      [isovalue](double value) { return value <= isovalue; });
  return positive > 0 && negative > 0;
}

inline std::vector<SurfaceTriangle> full_resolution_surface(const DatasetInfo& info,
                                                            std::span<const float> samples,
                                                            double isovalue) {
  assert(samples.size() == static_cast<std::size_t>(info.dims[0]) *
                               static_cast<std::size_t>(info.dims[1]) *
                               static_cast<std::size_t>(info.dims[2]));
  const GridField field(info, samples);
  const Affine to_world = grid_to_world(info);
  const std::int32_t side = std::int32_t{1} << info.grid_exponent;
  // The field is constant beyond one step around the samples.
  const std::int32_t first = std::max(1, (info.margin - 1) | 1);
  const auto last = [&](std::size_t axis) {
    return std::min(side - 1, info.margin + info.dims[axis] + 1);
  };
  std::vector<SurfaceTriangle> surface;
  Cube cube;
  for (std::int32_t z = first; z <= last(2); z += 2) {
    for (std::int32_t y = first; y <= last(1); y += 2) {
      for (std::int32_t x = first; x <= last(0); x += 2) {
        const auto point = [&](std::size_t i) -> std::array<std::int32_t, 3> {
          const auto number = static_cast<std::int32_t>(i);
          return {x + number % 3 - 1, y + number / 3 % 3 - 1, z + number / 9 - 1};
        };
        for (std::size_t i = 0; i < kPoints; ++i) cube.values[i] = field.at(point(i));
        if (!is_crossed(cube.values, isovalue)) continue;
        for (std::size_t i = 0; i < kPoints; ++i) {
          const auto p = point(i);
          cube.places[i] = to_world(
              {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
        }
        for (const Corners& tetrahedron : kTetrahedra) {
          add_surface(cube, tetrahedron, isovalue, surface);
        }
      }
    }
  }
  return surface;
}

}  // namespace multitetra::testing
