// The isosurface of a volume at full resolution: what meshes are compared with.
//
// It is what marching tetrahedra makes in the framework's finest tetrahedra, with the vertices at
// the exact crossings of their edges instead of on the lattice. In each tetrahedron that is the
// isosurface of the linear interpolation of its corners.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "common/mesh/components.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/request/dataset_info.hpp"
#include "server/certify/triangle_mesh.hpp"
#include "server/core/framework/field.hpp"

namespace multitetra {

// The facts of a volume that describe its grid: dims, type, spacing, map to the world, outside,
// margin, exponent and void samples.
[[nodiscard]] DatasetInfo grid_info(const Volume& volume, std::optional<double> outside,
                                    std::int32_t margin);

struct ReferenceSurface {
  // In world coordinates, facing low values. Where a sample is the isovalue itself, vertices on
  // different edges have the same place.
  TriangleMesh mesh;
  // The topology of the surface on the lattice, where vertices on different edges differ.
  MeshTopology topology;
  MeshComponents components;  // Those of `mesh`, measured on the lattice.
};

// Chooses the components that stay, one entry each, from the vertices in the world and the
// components of the whole surface.
using ChooseComponents =
    std::function<std::vector<char>(const std::vector<Vec3>& vertices, const MeshComponents& all)>;

// Takes time for one pass over the samples and for the surface, on all threads; memory is about 100
// bytes a triangle. Requires a field of the volume that `info` was made from. Without `choose` all
// components stay.
[[nodiscard]] ReferenceSurface reference_surface(const Field& field, const DatasetInfo& info,
                                                 double isovalue,
                                                 const ChooseComponents& choose = {});

}  // namespace multitetra
