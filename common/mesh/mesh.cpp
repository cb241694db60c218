#include "common/mesh/mesh.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "common/mesh/vertex_numbers.hpp"

namespace multitetra {
namespace {

// Returns whether every mesh has a value for each vertex.
template <typename Values>
bool all_have(std::span<const LatticeMesh* const> meshes, Values LatticeMesh::*member) {
  return std::all_of(meshes.begin(), meshes.end(), [member](const LatticeMesh* mesh) {
    const std::size_t values = (mesh->*member).size();
    assert(values == 0 || values == mesh->vertices.size());
    return values == mesh->vertices.size();
  });
}

}  // namespace

LatticeMesh index_triangles(std::span<const LatticeTriangle> triangles, int resolution) {
  LatticeMesh mesh{.resolution = resolution, .vertices = {}, .triangles = {}};
  mesh.vertices.reserve(triangles.size() / 2 + 8);
  mesh.triangles.reserve(triangles.size());
  VertexNumbers numbers(triangles.size() / 2);
  for (const LatticeTriangle& triangle : triangles) {
    mesh.triangles.push_back({numbers.number(triangle[0], mesh.vertices),
                              numbers.number(triangle[1], mesh.vertices),
                              numbers.number(triangle[2], mesh.vertices)});
  }
  return mesh;
}

LatticeMesh in_canonical_order(const LatticeMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return mesh.vertices[a].key() < mesh.vertices[b].key();
  });
  LatticeMesh result{.resolution = mesh.resolution, .vertices = {}, .triangles = {}};
  result.vertices.reserve(order.size());
  result.triangles.reserve(mesh.triangles.size());
  std::vector<std::uint32_t> number_of(order.size());
  for (const std::uint32_t vertex : order) {
    number_of[vertex] = static_cast<std::uint32_t>(result.vertices.size());
    result.vertices.push_back(mesh.vertices[vertex]);
    if (!mesh.normals.empty()) result.normals.push_back(mesh.normals[vertex]);
    if (!mesh.scalars.empty()) result.scalars.push_back(mesh.scalars[vertex]);
  }
  for (const TriangleIndices& t : mesh.triangles) {
    TriangleIndices corners = {number_of[t[0]], number_of[t[1]], number_of[t[2]]};
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    result.triangles.push_back(corners);
  }
  std::sort(result.triangles.begin(), result.triangles.end());
  return result;
}

LatticeMesh weld(std::span<const LatticeMesh* const> meshes, int resolution) {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  for (const LatticeMesh* mesh : meshes) {
    assert(mesh->resolution == resolution);
    vertices += mesh->vertices.size();
    triangles += mesh->triangles.size();
  }
  const bool has_normals = all_have(meshes, &LatticeMesh::normals);
  const bool has_scalars = all_have(meshes, &LatticeMesh::scalars);
  LatticeMesh whole{.resolution = resolution, .vertices = {}, .triangles = {}};
  whole.vertices.reserve(vertices);
  if (has_normals) whole.normals.reserve(vertices);
  if (has_scalars) whole.scalars.reserve(vertices);
  whole.triangles.reserve(triangles);
  VertexNumbers numbers(vertices);
  std::vector<std::uint32_t> number_of;
  for (const LatticeMesh* mesh : meshes) {
    number_of.clear();
    for (std::size_t i = 0; i < mesh->vertices.size(); ++i) {
      number_of.push_back(numbers.number(mesh->vertices[i], whole.vertices));
      if (has_normals && whole.normals.size() < whole.vertices.size()) {
        whole.normals.push_back(mesh->normals[i]);
      }
      if (has_scalars && whole.scalars.size() < whole.vertices.size()) {
        whole.scalars.push_back(mesh->scalars[i]);
      }
    }
    for (const TriangleIndices& t : mesh->triangles) {
      whole.triangles.push_back({number_of[t[0]], number_of[t[1]], number_of[t[2]]});
    }
  }
  return whole;
}

LatticeMesh weld(std::span<const LatticeMesh> meshes, int resolution) {
  std::vector<const LatticeMesh*> pointers;
  for (const LatticeMesh& mesh : meshes) pointers.push_back(&mesh);
  return weld(pointers, resolution);
}

namespace {

// Returns the largest displacements along the world's axes that together move no point by more than
// `distance` along an axis of the grid.
Vec3 world_limits(const Affine& grid_to_world, double distance) {
  const Affine to_grid = inverse(grid_to_world);
  Vec3 limits;
  limits.fill(std::numeric_limits<double>::infinity());
  for (std::size_t row = 0; row < 3; ++row) {
    // A displacement d moves the grid coordinate by the sum of parts[axis] d[axis].
    Vec3 parts;
    for (std::size_t axis = 0; axis < 3; ++axis) parts[axis] = std::abs(to_grid.columns[axis][row]);
    const auto count = static_cast<double>(3 - std::count(parts.begin(), parts.end(), 0.0));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      limits[axis] = std::min(limits[axis], distance / (count * parts[axis]));
    }
  }
  return limits;
}

}  // namespace

PositionedMesh positioned(const LatticeMesh& mesh, const Affine& grid_to_world) {
  PositionedMesh result;
  result.positions.reserve(mesh.vertices.size());
  for (const LatticePoint& vertex : mesh.vertices) {
    result.positions.push_back(grid_to_world(grid_coordinates(vertex, mesh.resolution)));
  }
  result.rounding_limits =
      world_limits(grid_to_world, std::ldexp(kMaxVertexRounding, -mesh.resolution));
  result.triangles = mesh.triangles;
  result.normals = mesh.normals;
  result.scalars = mesh.scalars;
  if (grid_to_world.determinant() < 0) {
    for (TriangleIndices& t : result.triangles) std::swap(t[1], t[2]);
  }
  return result;
}

bool is_unit(const UnitVector& v) {
  const auto square = [](float x) { return static_cast<double>(x) * static_cast<double>(x); };
  return std::abs(square(v[0]) + square(v[1]) + square(v[2]) - 1) < 1e-5;
}

}  // namespace multitetra
