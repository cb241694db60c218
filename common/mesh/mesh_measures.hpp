// The area of a surface, and the volume it encloses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/mesh/components.hpp"
#include "common/mesh/mesh.hpp"

namespace multitetra {

struct SurfaceMeasures {
  double area = 0;  // In square world units.
  // In cubic world units; positive around high values, negative around low ones (holes). Absent if
  // the surface has a border and so encloses nothing.
  std::optional<double> volume = {};
  // The sums over edges of length times the angle by which the surface bends there, in world units
  // and radians: around high values, and around low ones.
  double convex_bend = 0;
  double concave_bend = 0;
  std::uint64_t vertices = 0;
};

// Returns a bound of the difference between this volume and that inside another closed surface, if
// a map between the two moves no point farther than `distance`, and neither intersects itself.
//
// The points between the surfaces are swept by the segments of the map, so they lie within
// `distance` d of this surface: those inside it on one side, those outside on the other. The
// nearest point of the surface is inside a triangle, on an edge or at a vertex. These points fill
// at most the area times d, for edges a wedge of half the bend times d^2 (only where the surface
// bends away from this side), and for a vertex the part of a ball in a convex cone, 2 pi / 3 d^3:
// the tube formula of Steiner and Weyl, as an inequality.
[[nodiscard]] double volume_bound(const SurfaceMeasures& measures, double distance);

// Returns the measures of each component, in order. Volumes are computed exactly in integers and
// rounded once. Areas are sums of one rounded number per triangle.
[[nodiscard]] std::vector<SurfaceMeasures> measures_of(const LatticeMesh& mesh,
                                                       const MeshComponents& components,
                                                       const Affine& grid_to_world);

// Returns the total; it has a volume only if every component has one.
[[nodiscard]] SurfaceMeasures sum_of(const std::vector<SurfaceMeasures>& measures);

// Returns the total of the components with at least this diagonal, in grid steps.
[[nodiscard]] SurfaceMeasures measures_from(const LatticeMesh& mesh, double min_diagonal,
                                            const Affine& grid_to_world);

// Cavities that are filled when their walls, components of their own, are removed.
struct FilledCavities {
  std::size_t count = 0;
  double volume = 0;  // In cubic world units.
};
// Returns those of the components without at least this diagonal, in grid steps: closed surfaces
// around low values. Those within the bounding box of another removed component do not count: they
// vanish with it. Measures the removed components only.
[[nodiscard]] FilledCavities filled_cavities(const LatticeMesh& mesh,
                                             const MeshComponents& components, double min_diagonal,
                                             const Affine& grid_to_world);

}  // namespace multitetra
