// The connected components of a surface: which of them are large, and the surface without the
// others. Noise in scans makes thousands of small ones around the main surface.
//
//   const MeshComponents parts = components_of(mesh);
//   const LatticeMesh organs = with_components(mesh, parts, /*least_diagonal=*/10);
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace multitetra {

struct MeshComponents {
  std::vector<std::uint32_t> of_vertex;  // The component of each vertex that a triangle has.
  // The diagonal of each component's bounding box, in grid steps. Components are in the order of
  // their first vertices.
  std::vector<double> diagonals;

  // The one with the longest diagonal, the first of several; 0 where there is none.
  [[nodiscard]] std::uint32_t largest() const;
  // The number of components with at least that diagonal.
  [[nodiscard]] std::size_t count_from(double least_diagonal) const;
};

// Requires that every vertex has a triangle.
[[nodiscard]] MeshComponents components_of(const LatticeMesh& mesh);

// The mesh's components with at least that diagonal, in the mesh's order, with their normals.
[[nodiscard]] LatticeMesh with_components(const LatticeMesh& mesh, const MeshComponents& components,
                                          double least_diagonal);

}  // namespace multitetra
