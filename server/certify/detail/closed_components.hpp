// The orientation of the closed components of a surface.
#pragma once

#include <span>
#include <vector>

#include "common/mesh/components.hpp"
#include "common/mesh/mesh_measures.hpp"
#include "common/mesh/triangle_mesh.hpp"
#include "server/certify/certificate.hpp"

namespace multitetra {

// kUnknown: closed, with a volume within the rounding error.
enum class Facing : signed char { kInwards = -1, kOpen = 0, kOutwards = 1, kUnknown = 2 };

// Returns the orientations of components with these measures; those without a volume are open.
[[nodiscard]] std::vector<Facing> facings_of(std::span<const SurfaceMeasures> measures);

// Returns those of a mesh in world coordinates. `is_open[i]` is 1 if component i has an open edge;
// `rounding` is the largest displacement of a vertex by rounding, in world units.
[[nodiscard]] std::vector<Facing> facings_of(const TriangleMesh& mesh,
                                             const MeshComponents& components,
                                             const std::vector<char>& is_open, double rounding);

[[nodiscard]] ClosedComponents counts_of(std::span<const Facing> facings);

}  // namespace multitetra
