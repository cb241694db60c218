// A surface as files have it, and the bytes of files with one or several. What a file holds is read
// back from its bytes, so that no report speaks of anything else.
//
//   const OutputSurface output = output_surface(mesh, /*min_component=*/0, {grid_to_world(info)}, info);
//   const NamedSurface surface = {surface_name(info), &output};
//   const SurfaceFile file = surface_file({&surface, 1}, MeshFormat::kPly, MeshCodec::kNone);
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/base/affine.hpp"
#include "common/dataset/dataset_info.hpp"
#include "common/dataset/surface_name.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/mesh_measures.hpp"
#include "common/request/mesh_codec.hpp"
#include "common/wire/mesh_files.hpp"
#include "common/wire/written_mesh.hpp"

namespace multitetra {

// The coordinates of a file.
struct OutputSpace {
  Affine map = {};             // From grid coordinates.
  PhysicalMeaning world = {};  // Their meaning; empty for sample indices.
};

// A surface in a file's coordinates, with normals, without components that are too small. Its order
// depends only on its triangles (in_canonical_order()).
struct OutputSurface {
  PositionedMesh mesh;
  PhysicalMeaning world = {};
  // Vertices are at multiples of 2^-lattice grid steps.
  int lattice = kDefaultLatticeResolution;
  double min_component = 0;  // In samples: components with a shorter diagonal were removed.
  // The number of components in the mesh.
  std::size_t components = 0;
  // The number of components of the whole surface.
  std::size_t total_components = 0;
  double longest_diagonal = 0;  // Of all components, in samples.
  FilledCavities filled = {};   // By removing components.
  // The vertices of large components: those whose diagonal is at least an eighth of the largest
  // one's.
  std::vector<std::uint32_t> large = {};
};
// `min_component` is the shortest diagonal of components that stay, in samples.
[[nodiscard]] OutputSurface output_surface(const LatticeMesh& surface, double min_component,
                                           const OutputSpace& space, const DatasetInfo& info);

struct NamedSurface {
  SurfaceName name = {};
  const OutputSurface* surface = nullptr;  // Not null.
};

struct SurfaceFile {
  std::string bytes;
  // What the bytes hold of each surface; nothing of those without triangles.
  std::vector<WrittenMesh> written;
};
// Several surfaces must be of one world, and the format GLB. Throws MeshCoordinatesError if the
// format cannot hold the coordinates, std::logic_error if it would not hold the surfaces.
[[nodiscard]] SurfaceFile surface_file(std::span<const NamedSurface> surfaces, MeshFormat format,
                                       MeshCodec codec, ReadBack counted = ReadBack::kTopology);

}  // namespace multitetra
