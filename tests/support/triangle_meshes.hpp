// Triangle meshes in any coordinates, constructed or extracted by the server.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "common/mesh/triangle_mesh.hpp"
#include "server/extraction/surface_extractor.hpp"

namespace multitetra::testing {

inline TriangleMesh in_world(const LatticeMesh& mesh, const DatasetInfo& info) {
  const Affine to_world = grid_to_world(info);
  TriangleMesh result;
  for (const LatticePoint& vertex : mesh.vertices) {
    result.vertices.push_back(to_world(grid_coordinates(vertex, mesh.resolution)));
  }
  result.triangles = mesh.triangles;
  return result;
}

// Extracts the requested surface.
inline TriangleMesh extracted(const DatasetPtr& dataset, const IsosurfaceRequest& request) {
  const TiledMesh surface = SurfaceExtractor(dataset).extract({.request = request});
  return in_world(weld(surface.tiles, request.lattice_resolution), dataset->info);
}

inline TriangleMesh shifted(TriangleMesh mesh, const Vec3& by) {
  for (Vec3& vertex : mesh.vertices) vertex = sum(vertex, by);
  return mesh;
}

inline TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh both = a;
  const auto first = static_cast<std::uint32_t>(a.vertices.size());
  both.vertices.insert(both.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const TriangleIndices& t : b.triangles) {
    both.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return both;
}

// An axis-parallel box, facing outwards.
inline TriangleMesh box(const Vec3& low, const Vec3& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back({(i & 1) != 0 ? high[0] : low[0], (i & 2) != 0 ? high[1] : low[1],
                             (i & 4) != 0 ? high[2] : low[2]});
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

// A sphere with poles along z and `rings` rings of 2 * rings vertices.
inline TriangleMesh sphere(const Vec3& center, double radius, std::uint32_t rings) {
  TriangleMesh mesh;
  const std::uint32_t around = 2 * rings;
  mesh.vertices.push_back({center[0], center[1], center[2] + radius});
  for (std::uint32_t ring = 1; ring <= rings; ++ring) {
    const double polar = std::numbers::pi * ring / (rings + 1);
    for (std::uint32_t i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      mesh.vertices.push_back({center[0] + radius * std::sin(polar) * std::cos(angle),
                               center[1] + radius * std::sin(polar) * std::sin(angle),
                               center[2] + radius * std::cos(polar)});
    }
  }
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back({center[0], center[1], center[2] - radius});
  const auto at = [&](std::uint32_t ring, std::uint32_t i) {
    return 1 + (ring - 1) * around + i % around;
  };
  for (std::uint32_t i = 0; i < around; ++i) {
    mesh.triangles.push_back({0, at(1, i), at(1, i + 1)});
    mesh.triangles.push_back({at(rings, i), last, at(rings, i + 1)});
    for (std::uint32_t ring = 1; ring < rings; ++ring) {
      mesh.triangles.push_back({at(ring, i), at(ring + 1, i), at(ring + 1, i + 1)});
      mesh.triangles.push_back({at(ring, i), at(ring + 1, i + 1), at(ring, i + 1)});
    }
  }
  return mesh;
}

}  // namespace multitetra::testing
