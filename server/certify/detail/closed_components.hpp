// Counts the closed components of a surface by their orientation.
#pragma once

#include <span>
#include <vector>

#include "common/mesh/components.hpp"
#include "common/mesh/mesh_measures.hpp"
#include "server/certify/certificate.hpp"
#include "server/certify/triangle_mesh.hpp"

namespace multitetra {

// Returns the counts for components with these measures; those without a volume are open.
[[nodiscard]] ClosedComponents closed_components(std::span<const SurfaceMeasures> measures);

// Returns the counts for a mesh in world coordinates. `is_open[i]` is 1 if component i has an open
// edge; `rounding` is the largest displacement of a vertex by rounding, in world units.
[[nodiscard]] ClosedComponents closed_components(const TriangleMesh& mesh,
                                                 const MeshComponents& components,
                                                 const std::vector<char>& is_open, double rounding);

}  // namespace multitetra
