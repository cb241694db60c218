// The isosurface of a volume at full resolution, with which meshes are compared.
//
// It is the result of marching tetrahedra in the framework's finest tetrahedra, except that
// vertices lie exactly on the crossings of edges instead of on the lattice. Within each tetrahedron
// it is the isosurface of the linear interpolation of the corners.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "common/mesh/components.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/mesh/triangle_mesh.hpp"
#include "server/certify/certificate.hpp"
#include "server/certify/detail/closed_components.hpp"
#include "server/core/framework/field.hpp"

namespace multitetra {

// Returns the fields that describe a volume's grid: dims, type, spacing, map to the world, outside,
// margin, exponent and void samples.
[[nodiscard]] DatasetInfo grid_info(const Volume& volume, std::optional<double> outside,
                                    std::int32_t margin);

struct ReferenceSurface {
  // In world coordinates, facing low values. Vertices on different edges coincide if a sample is
  // equal to the isovalue.
  TriangleMesh mesh;
  // Topology of the surface on the lattice, where vertices on different edges are distinct.
  MeshTopology topology;
  MeshComponents components;    // Components of `mesh`, measured on the lattice.
  std::vector<Facing> facings;  // Their orientations.
  // The diagonals of components that `choose` removed, in grid steps.
  std::vector<double> removed_diagonals;
};

// Returns for each component of the full surface whether to keep it. Takes world coordinates.
using ChooseComponents =
    std::function<std::vector<char>(const std::vector<Vec3>& vertices, const MeshComponents& all)>;

// Takes one pass over the samples plus the extraction, on all threads, and about 100 bytes of
// memory per triangle. Requires the field of the volume that `info` describes. Without `choose`,
// keeps all components. Throws Cancelled soon after `stop` is triggered.
[[nodiscard]] ReferenceSurface reference_surface(const Field& field, const DatasetInfo& info,
                                                 double isovalue,
                                                 const ChooseComponents& choose = {},
                                                 const std::stop_token& stop = {});

}  // namespace multitetra
