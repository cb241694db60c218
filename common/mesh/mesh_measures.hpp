// Area of a surface, and the volume that it encloses.
#pragma once

#include <optional>
#include <vector>

#include "common/mesh/components.hpp"
#include "common/mesh/mesh.hpp"

namespace multitetra {

struct SurfaceMeasures {
  double area = 0;  // In square units of the world.
  // In cubic units of the world; positive around high values, negative around low ones, as of a
  // hole. None where the surface has a border: it encloses nothing then.
  std::optional<double> volume = {};
};

// One for each component, in their order. Volumes are exact before they are rounded once: vertices
// are integers. Areas are sums of one rounded number a triangle.
[[nodiscard]] std::vector<SurfaceMeasures> measures_of(const LatticeMesh& mesh,
                                                       const MeshComponents& components,
                                                       const Affine& grid_to_world);

// All of them together: a volume only where each of them has one.
[[nodiscard]] SurfaceMeasures sum_of(const std::vector<SurfaceMeasures>& measures);

// Measures of the components with at least that diagonal, in grid steps.
[[nodiscard]] SurfaceMeasures measures_from(const LatticeMesh& mesh, double least_diagonal,
                                            const Affine& grid_to_world);

}  // namespace multitetra
