// Components of the full surface that a mesh lacks: because small ones were removed from it, or for
// no known reason.
#pragma once

#include <optional>

#include "common/mesh/surface_distance.hpp"
#include "server/certify/certificate.hpp"
#include "server/certify/detail/reference_surface.hpp"
#include "server/certify/triangle_mesh.hpp"

namespace multitetra {

// The components that a mesh without those shorter than `min_component` has to have.
class ExpectedComponents {
 public:
  // `allowed` is the distance of the mesh from the full surface, `voxel` the smallest spacing, both
  // in world units; `min_component` is in grid steps.
  ExpectedComponents(const TriangleMesh& mesh, double min_component, double allowed, double voxel);

  // Whether a component with that diagonal, in grid steps, and that vertex belongs to them. Points
  // move by at most `allowed`, and so a diagonal by less than four times that: near `min_component`
  // the component is expected where it is in the mesh.
  [[nodiscard]] bool contain(double diagonal, const Vec3& vertex) const;

 private:
  NearestTriangle nearest_;
  double least_;
  double most_;
  double allowed_;
};

// The components of the full surface that are farther than `allowed` from the mesh with every
// vertex. nullopt where there is none, or where others have a vertex that is farther, too.
[[nodiscard]] std::optional<MissingComponents> missing_components(const ReferenceSurface& reference,
                                                                  const TriangleMesh& mesh,
                                                                  double allowed);

}  // namespace multitetra
