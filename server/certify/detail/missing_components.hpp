// Components of the full surface that a mesh lacks: small ones that were removed, or any others.
#pragma once

#include <optional>
#include <vector>

#include "common/base/affine.hpp"
#include "common/mesh/components.hpp"
#include "common/mesh/triangle_mesh.hpp"
#include "server/certify/certificate.hpp"
#include "server/certify/detail/reference_surface.hpp"

namespace multitetra {

// Returns the components of a mesh, measured in grid coordinates. Every vertex must be used.
[[nodiscard]] MeshComponents components_of(const TriangleMesh& mesh, const Affine& world_to_grid);

// Chooses the components of the full surface that must be in a mesh from which components shorter
// than `min_component` grid steps were removed. `allowed` is the allowed distance of the mesh from
// the full surface, `voxel` the smallest spacing, both in world units; `components` are those of
// the mesh.
//
// Points move by at most `allowed`, so a diagonal changes by less than four times that. Of the
// components this close to `min_component`, only those within `allowed` of the mesh can be in it:
// of these, the longest are chosen, as many as the mesh has besides the clearly longer components.
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
                                         const MeshComponents& all, double max_diagonal) const;
};

// Returns the components of the full surface with most of their vertices farther than `allowed`
// from the mesh; nullopt if there are none, or if another component has a vertex that far, too.
[[nodiscard]] std::optional<MissingComponents> missing_components(const ReferenceSurface& reference,
                                                                  const TriangleMesh& mesh,
                                                                  const MeshComponents& components,
                                                                  double allowed);

}  // namespace multitetra
