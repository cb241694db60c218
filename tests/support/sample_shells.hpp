// Sample shells of whole volumes, tile by tile, and the surface that they represent, marched
// tetrahedron by tetrahedron with core's rules.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "common/codec/shell_decoder.hpp"
#include "common/codec/shell_encoder.hpp"
#include "common/mesh/mesh.hpp"
#include "server/core/framework/field.hpp"
#include "server/core/surface/marching_tetrahedra.hpp"

namespace multitetra::testing {

// A box of samples that owns its memory.
struct OwnedBox {
  std::variant<std::vector<std::uint8_t>, std::vector<std::int8_t>, std::vector<std::uint16_t>,
               std::vector<std::int16_t>, std::vector<float>>
      samples;
  std::array<std::int32_t, 3> data_samples{};
  std::array<std::int32_t, 3> origin{};
  std::uint32_t layers = 0;
  float layer_value = 0;

  [[nodiscard]] shell::ShellBox box() const {
    const auto block = std::visit(
        [this](const auto& values) -> shell::AnySampleBlock {
          using Sample = typename std::decay_t<decltype(values)>::value_type;
          return shell::SampleBlock<Sample>{
              .first = values.data(),
              .row = data_samples[0],
              .slice = std::ptrdiff_t{data_samples[0]} * data_samples[1]};
        },
        samples);
    return {.samples = block,
            .data_samples = data_samples,
            .origin = origin,
            .layers = layers,
            .layer_value = layer_value};
  }
  [[nodiscard]] int layer(int axis, bool high) const {
    return static_cast<int>(layers >> (2 * axis + (high ? 1 : 0)) & 1U);
  }
  // The size along the axis, including layers.
  [[nodiscard]] int size(int axis) const {
    return data_samples[static_cast<std::size_t>(axis)] + layer(axis, false) + layer(axis, true);
  }
  // The value at a point of the box, as in core.
  [[nodiscard]] float value(int x, int y, int z) const {
    const int i = x - layer(0, false);
    const int j = y - layer(1, false);
    const int k = z - layer(2, false);
    if (std::min({i, j, k}) < 0 || i >= data_samples[0] || j >= data_samples[1] ||
        k >= data_samples[2]) {
      return layer_value;
    }
    const auto index = static_cast<std::size_t>(i + data_samples[0] * (j + data_samples[1] * k));
    return std::visit([index](const auto& v) { return static_cast<float>(v[index]); }, samples);
  }
};

// Returns the part of a volume's field that can contain surface in the cube from `low` to `high`,
// in units of `spacing`; nullopt if no cell of the cube has a value at each corner.
inline std::optional<OwnedBox> box_in(const Volume& volume, std::optional<double> outside,
                                      std::int32_t margin, std::int32_t spacing,
                                      std::array<std::int32_t, 3> low,
                                      std::array<std::int32_t, 3> high) {
  OwnedBox box;
  std::array<std::int32_t, 3> first{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t data_first = (margin + spacing - 1) / spacing;
    const std::int32_t data_last = (margin + volume.dims[axis] - 1) / spacing;
    first[axis] = std::max(low[axis], data_first);
    const std::int32_t last = std::min(high[axis], data_last);
    if (last < first[axis]) return std::nullopt;
    box.data_samples[axis] = last - first[axis] + 1;
    box.origin[axis] = first[axis];
    if (outside && first[axis] > low[axis]) {
      box.layers |= 1U << (2 * axis);
      --box.origin[axis];
    }
    if (outside && last < high[axis]) box.layers |= 2U << (2 * axis);
    if (box.size(static_cast<int>(axis)) < 2) return std::nullopt;
  }
  box.layer_value = outside ? static_cast<float>(*outside) : 0;
  std::visit(
      [&](const auto& all) {
        std::decay_t<decltype(all)> part;
        for (std::int32_t z = 0; z < box.data_samples[2]; ++z) {
          for (std::int32_t y = 0; y < box.data_samples[1]; ++y) {
            for (std::int32_t x = 0; x < box.data_samples[0]; ++x) {
              part.push_back(all[volume.index(spacing * (first[0] + x) - margin,
                                              spacing * (first[1] + y) - margin,
                                              spacing * (first[2] + z) - margin)]);
            }
          }
        }
        box.samples = std::move(part);
      },
      volume.samples);
  return box;
}

// Returns all tiles of `cells`^3 cells of a volume's field.
inline std::vector<OwnedBox> boxes_of(const Volume& volume, std::optional<double> outside,
                                      std::int32_t margin, std::int32_t spacing, int cells) {
  std::vector<OwnedBox> boxes;
  const std::int32_t n = (1 << Field(volume, outside, margin).grid().exponent()) / spacing;
  for (std::int32_t z = 0; z < n; z += cells) {
    for (std::int32_t y = 0; y < n; y += cells) {
      for (std::int32_t x = 0; x < n; x += cells) {
        auto box = box_in(volume, outside, margin, spacing, {x, y, z},
                          {std::min(x + cells, n), std::min(y + cells, n), std::min(z + cells, n)});
        if (box) boxes.push_back(*std::move(box));
      }
    }
  }
  return boxes;
}

struct DecodedShell {
  shell::ShellStatus status = shell::ShellStatus::kOk;
  LatticeMesh mesh;
};

inline DecodedShell decode_shell(const std::vector<std::uint8_t>& bytes) {
  static const auto decoder = std::make_unique<shell::ShellDecoder>();
  DecodedShell decoded;
  shell::ShellHeader header;
  decoded.status = shell::read_shell_header(bytes.data(), bytes.size(), header);
  if (decoded.status != shell::ShellStatus::kOk) return decoded;
  std::vector<shell::ShellVertex> vertices(header.vertices);
  std::vector<shell::ShellTriangle> triangles(header.triangles);
  decoded.status = decoder->decode(bytes.data(), bytes.size(), vertices.data(), triangles.data());
  if (decoded.status != shell::ShellStatus::kOk) return decoded;
  decoded.mesh.resolution = header.lattice_resolution;
  for (const auto& v : vertices) decoded.mesh.vertices.push_back({v.x, v.y, v.z});
  for (const auto& t : triangles) {
    decoded.mesh.triangles.push_back({t.corners[0], t.corners[1], t.corners[2]});
  }
  return decoded;
}

// Sorts triangles and rotates each to its smallest corner: equal for equal surfaces.
inline std::vector<LatticeTriangle> sorted_triangles(std::vector<LatticeTriangle> triangles) {
  for (LatticeTriangle& t : triangles) {
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}
inline std::vector<LatticeTriangle> sorted_triangles(const LatticeMesh& mesh) {
  std::vector<LatticeTriangle> triangles;
  for (const TriangleIndices& t : mesh.triangles) {
    triangles.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
  }
  return sorted_triangles(std::move(triangles));
}

// Returns the value, minus the isovalue, that a quantized shell represents.
inline double quantized(double value, double isovalue, int levels) {
  const double distance = std::abs(value - isovalue);
  if (!(distance > 0)) return value - isovalue;
  const double level = std::floor(std::log2(distance) * levels + 0.5);
  return (value > isovalue ? 1 : -1) * std::exp2(level / levels);
}

// value(x, y, z) at every point of a box, each computed once.
class BoxValues {
 public:
  template <typename Value>
  BoxValues(const OwnedBox& box, const Value& value) : size_x_(box.size(0)), size_y_(box.size(1)) {
    for (int z = 0; z < box.size(2); ++z) {
      for (int y = 0; y < size_y_; ++y) {
        for (int x = 0; x < size_x_; ++x) values_.push_back(value(x, y, z));
      }
    }
  }
  [[nodiscard]] double at(int x, int y, int z) const {
    return values_[static_cast<std::size_t>(x + size_x_ * (y + size_y_ * z))];
  }
  // Whether the corners of a cell are on both sides of the isovalue.
  [[nodiscard]] bool are_mixed(int x, int y, int z, double isovalue) const {
    int above = 0;
    for (int i = 0; i < 8; ++i) {
      above += at(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2)) > isovalue ? 1 : 0;
    }
    return above != 0 && above != 8;
  }

 private:
  int size_x_;
  int size_y_;
  std::vector<double> values_;
};

// Returns the surface in a box: `value(x, y, z)` at its points, NaN where void. Every cell consists
// of six tetrahedra around the diagonal from its corner with even coordinates.
template <typename Value>
std::vector<LatticeTriangle> marched(const OwnedBox& box, double isovalue, int resolution,
                                     std::int32_t spacing, const Value& value) {
  constexpr std::array<std::array<int, 3>, 6> kOrders = {
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  const BoxValues all(box, value);
  std::vector<LatticeTriangle> triangles;
  const auto add_tetrahedron = [&](const std::array<GridPoint, 4>& corners) {
    std::array<double, 4> values{};
    std::array<GridPoint, 4> points{};
    unsigned signs = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      values[i] = all.at(corners[i].x, corners[i].y, corners[i].z);
      if (std::isnan(values[i])) return;
      if (values[i] > isovalue) signs |= 1U << i;
      points[i] = spacing * (corners[i] + GridPoint{box.origin[0], box.origin[1], box.origin[2]});
    }
    const bool is_negative = six_times_volume(points[0], points[1], points[2], points[3]) < 0;
    const MarchingCase& c = kMarchingCases[signs][is_negative ? 1 : 0];
    std::array<LatticePoint, 4> p{};
    for (std::size_t k = 0; k < c.corners; ++k) {
      const auto [i, j] = kTetrahedronEdges[c.edges[k]];
      p[k] = lattice_vertex(points[i], values[i], points[j], values[j], isovalue, resolution);
    }
    if (c.corners == 3) triangles.push_back({p[0], p[1], p[2]});
    if (c.corners != 4) return;
    const bool along_first = is_cut_along_first(p[0], p[1], p[2], p[3]);
    triangles.push_back(along_first ? LatticeTriangle{p[0], p[1], p[2]}
                                    : LatticeTriangle{p[1], p[2], p[3]});
    triangles.push_back(along_first ? LatticeTriangle{p[0], p[2], p[3]}
                                    : LatticeTriangle{p[1], p[3], p[0]});
  };
  for (int z = 0; z + 1 < box.size(2); ++z) {
    for (int y = 0; y + 1 < box.size(1); ++y) {
      for (int x = 0; x + 1 < box.size(0); ++x) {
        if (!all.are_mixed(x, y, z, isovalue)) continue;
        const std::array<int, 3> cell = {x, y, z};
        std::array<int, 3> even{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          even[axis] = cell[axis] + ((cell[axis] + box.origin[axis]) & 1);
        }
        for (const auto& order : kOrders) {
          std::array<GridPoint, 4> corners{};
          std::array<int, 3> at = even;
          corners[0] = {at[0], at[1], at[2]};
          for (std::size_t k = 0; k < 3; ++k) {
            const auto axis = static_cast<std::size_t>(order[k]);
            at[axis] = 2 * cell[axis] + 1 - at[axis];
            corners[k + 1] = {at[0], at[1], at[2]};
          }
          add_tetrahedron(corners);
        }
      }
    }
  }
  return triangles;
}

}  // namespace multitetra::testing
