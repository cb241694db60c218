// The connected components of a surface, and removal of the small ones. Noise in scans creates
// thousands of small components around the main surface.
//
//   const MeshComponents parts = components_of(mesh);
//   const LatticeMesh organs = with_components(mesh, parts, /*min_diagonal=*/10);
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/mesh/mesh.hpp"

namespace multitetra {

// A minimum diagonal that stands for the longest one that occurs: only the largest component stays.
inline constexpr double kLargestAlone = std::numeric_limits<double>::infinity();

struct MeshComponents {
  std::vector<std::uint32_t> of_vertex;  // The component of each vertex.
  // The diagonal of each component's bounding box, in grid steps. Components are ordered by their
  // first vertices.
  std::vector<double> diagonals;

  // Returns the component with the longest diagonal (the first of several); 0 if there is none.
  [[nodiscard]] std::uint32_t largest() const;
  // Returns the number for a least diagonal: the longest diagonal for kLargestAlone.
  [[nodiscard]] double least(double min_diagonal) const;
  // Returns the number of components with at least this diagonal.
  [[nodiscard]] std::size_t count_at_least(double min_diagonal) const;
};

// Requires that every vertex is used by a triangle.
[[nodiscard]] MeshComponents components_of(const LatticeMesh& mesh);

// Returns the components with at least this diagonal, in order, with normals and scalars.
[[nodiscard]] LatticeMesh with_components(const LatticeMesh& mesh, const MeshComponents& components,
                                          double min_diagonal);
// Returns the other ones likewise.
[[nodiscard]] LatticeMesh without_components(const LatticeMesh& mesh,
                                             const MeshComponents& components, double min_diagonal);

}  // namespace multitetra
