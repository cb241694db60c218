#include "server/certify/detail/reference_surface.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "common/base/in_parallel.hpp"
#include "server/certify/detail/closed_components.hpp"
#include "server/core/errors/error_based_model.hpp"
#include "server/core/surface/tiling.hpp"

namespace multitetra {
namespace {

constexpr int kBlockExponent = 3;

// Returns whether the closed cube has values on both sides of the isovalue.
template <typename SampledField>
bool is_crossed(const SampledField& field, const OctreeCube& cube, double isovalue) {
  const std::int32_t side = cube.side();
  const GridPoint low = {cube.x * side, cube.y * side, cube.z * side};
  bool has_positive = false;
  bool has_negative = false;
  for (std::int32_t z = 0; z <= side; ++z) {
    for (std::int32_t y = 0; y <= side; ++y) {
      for (std::int32_t x = 0; x <= side; ++x) {
        const auto value = static_cast<double>(field.at(low + GridPoint{x, y, z}));
        has_positive = has_positive || value > isovalue;
        has_negative = has_negative || value <= isovalue;
      }
    }
    if (has_positive && has_negative) return true;
  }
  return false;
}

// Returns the crossed cubes of the grid, row by row.
std::vector<OctreeCube> crossed_cubes(const Field& field, double isovalue, int exponent,
                                      const std::stop_token& stop) {
  const std::int32_t most = field.grid().side() >> exponent;
  const GridPoint last = field.last_sample();
  const auto count = [&](std::int32_t coordinate) {  // The surface ends one step beyond the data.
    return std::min(most, ((coordinate + 1) >> exponent) + 1);
  };
  const GridPoint counts = {count(last.x), count(last.y), count(last.z)};
  std::vector<std::vector<OctreeCube>> rows(static_cast<std::size_t>(counts.y) *
                                            static_cast<std::size_t>(counts.z));
  const auto add_row = [&](std::size_t row) {
    const auto y = static_cast<std::int32_t>(row) % counts.y;
    const auto z = static_cast<std::int32_t>(row) / counts.y;
    field.visit([&](const auto& sampled) {
      for (std::int32_t x = 0; x < counts.x; ++x) {
        const OctreeCube cube{exponent, x, y, z};
        if (is_crossed(sampled, cube, isovalue)) rows[row].push_back(cube);
      }
    });
  };
  in_parallel(rows.size(), add_row, stop);
  std::vector<OctreeCube> cubes;
  for (const auto& row : rows) cubes.insert(cubes.end(), row.begin(), row.end());
  return cubes;
}

LatticeMesh surface_on_lattice(const Field& field, double isovalue, const std::stop_token& stop) {
  const UniformModel finest(field.grid(), 3 * field.grid().exponent());
  const SurfaceOptions options{.isovalue = isovalue,
                               .max_triangles = std::numeric_limits<std::size_t>::max()};
  const std::vector<OctreeCube> cubes =
      crossed_cubes(field, isovalue, std::min(kBlockExponent, field.grid().exponent()), stop);
  std::vector<LatticeMesh> parts(cubes.size());
  const auto extract = [&](std::size_t i) {
    parts[i] = surface_in_cube(finest, field, cubes[i], options).rest;
  };
  in_parallel(cubes.size(), extract, stop);
  return weld(parts, options.lattice_resolution);
}

// Returns the ends of the edge of the finest tetrahedra in whose interior the lattice point lies.
// They differ by one step along each axis on which the point lies between grid points. Every edge
// joins points of different kinds (cube center, face center, edge midpoint, corner), so on those
// axes all coordinates of one end are even and those of the other odd.
std::array<GridPoint, 2> edge_of(const LatticePoint& vertex, int resolution) {
  std::array<GridPoint, 2> ends;
  const auto set = [&](std::int32_t GridPoint::*axis, std::int32_t coordinate) {
    const std::int32_t below = coordinate >> resolution;
    const bool is_between = (coordinate & ((1 << resolution) - 1)) != 0;
    ends[0].*axis = is_between ? below + (below & 1) : below;
    ends[1].*axis = is_between ? below + 1 - (below & 1) : below;
  };
  set(&GridPoint::x, vertex.x);
  set(&GridPoint::y, vertex.y);
  set(&GridPoint::z, vertex.z);
  return ends;
}

Vec3 as_vector(GridPoint p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

// Returns the crossings of the edges that contain the lattice points, in world coordinates.
std::vector<Vec3> crossings(const Field& field, const LatticeMesh& surface, double isovalue,
                            const Affine& to_world) {
  std::vector<Vec3> positions(surface.vertices.size());
  field.visit([&](const auto& sampled) {
    in_parallel(surface.vertices.size(), [&](std::size_t i) {
      const auto [a, b] = edge_of(surface.vertices[i], surface.resolution);
      const auto value_a = static_cast<double>(sampled.at(a));
      const auto value_b = static_cast<double>(sampled.at(b));
      assert((value_a > isovalue) != (value_b > isovalue));
      const double t = (isovalue - value_a) / (value_b - value_a);
      positions[i] = to_world(moved(as_vector(a), t, as_vector(b - a)));
    });
  });
  return positions;
}

}  // namespace

DatasetInfo grid_info(const Volume& volume, std::optional<double> outside, std::int32_t margin) {
  DatasetInfo info;
  info.dims = volume.dims;
  info.type = volume.type();
  info.spacing = volume.spacing;
  info.index_to_world = volume.index_to_world;
  info.meaning = volume.meaning;
  info.outside = outside;
  info.margin = margin;
  info.grid_exponent = grid_exponent_for(volume.dims, margin);
  if (const auto* const floats = std::get_if<std::vector<float>>(&volume.samples)) {
    info.void_samples =
        static_cast<std::uint64_t>(std::count_if(floats->begin(), floats->end(), is_void));
  }
  return info;
}

ReferenceSurface reference_surface(const Field& field, const DatasetInfo& info, double isovalue,
                                   const ChooseComponents& choose, const std::stop_token& stop) {
  LatticeMesh surface = surface_on_lattice(field, isovalue, stop);
  throw_if_stopped(stop);
  const Affine to_world = grid_to_world(info);
  ReferenceSurface reference;
  reference.mesh.vertices = crossings(field, surface, isovalue, to_world);
  reference.components = components_of(surface);
  if (choose) {
    MeshComponents chosen = reference.components;
    const std::vector<char> stays = choose(reference.mesh.vertices, chosen);
    for (std::size_t i = 0; i < stays.size(); ++i) {
      if (stays[i] == 0) reference.removed_diagonals.push_back(chosen.diagonals[i]);
      chosen.diagonals[i] = stays[i] != 0 ? 1 : 0;
    }
    surface = with_components(surface, chosen, /*min_diagonal=*/1);
    reference.mesh.vertices = crossings(field, surface, isovalue, to_world);
    reference.components = components_of(surface);
  }
  throw_if_stopped(stop);
  reference.topology = topology(surface, data_border(info, surface.resolution, 0));
  throw_if_stopped(stop);
  reference.facings = facings_of(measures_of(surface, reference.components, to_world));
  reference.mesh.triangles = std::move(surface.triangles);
  if (to_world.determinant() < 0) {
    for (TriangleIndices& t : reference.mesh.triangles) std::swap(t[1], t[2]);
  }
  return reference;
}

}  // namespace multitetra
