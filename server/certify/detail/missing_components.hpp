// Components of the full surface that a mesh lacks: because small ones were removed from it, or for
// no known reason.
#pragma once

#include <optional>
#include <vector>

#include "common/base/affine.hpp"
#include "common/mesh/components.hpp"
#include "server/certify/certificate.hpp"
#include "server/certify/detail/reference_surface.hpp"
#include "server/certify/triangle_mesh.hpp"

namespace multitetra {

// The components of a mesh whose vertices are all used, in grid coordinates.
[[nodiscard]] MeshComponents components_of(const TriangleMesh& mesh, const Affine& world_to_grid);

// The components of the full surface that a mesh without those shorter than `min_component`, in
// grid steps, has to have. `allowed` is the distance of the mesh from the full surface, `voxel` the
// smallest spacing, both in world units; `components` are the mesh's.
//
// Points move by at most `allowed`, and so a diagonal by less than four times that. Of the
// components that are so near to `min_component`, as many as the mesh has beside the longer ones
// are expected: the longest of those that lie within `allowed` of it.
struct ExpectedComponents {
  const TriangleMesh& mesh;
  const MeshComponents& components;
  double min_component = 0;
  double allowed = 0;
  double voxel = 1;

  [[nodiscard]] std::vector<char> operator()(const std::vector<Vec3>& vertices,
                                             const MeshComponents& all) const;

 private:
  [[nodiscard]] std::vector<char> absent(const std::vector<Vec3>& vertices,
                                         const MeshComponents& all, double most) const;
};

// The components of the full surface that are farther than `allowed` from the mesh with most of
// their vertices. nullopt where there is none, or where others have a vertex that is farther, too.
[[nodiscard]] std::optional<MissingComponents> missing_components(const ReferenceSurface& reference,
                                                                  const TriangleMesh& mesh,
                                                                  const MeshComponents& components,
                                                                  double allowed);

}  // namespace multitetra
