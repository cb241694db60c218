// A surface as a few whole meshes of decreasing detail, for viewers that load one file.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/isosurface_request.hpp"
#include "common/request/mesh_codec.hpp"
#include "server/tilesets/tileset.hpp"

namespace multitetra {

struct WholeLevel {
  IsosurfaceRequest request;
  // The bound of the two-sided Hausdorff distance to the full-resolution surface, including
  // rounding to the lattice. In world units.
  double error_bound = 0;
};

// Returns the levels, finest first. The first one has the requested error; each further one four
// times the previous error, up to a sixteenth of the volume's longest side. All keep the topology.
[[nodiscard]] std::vector<WholeLevel> whole_levels(const DatasetInfo& info,
                                                   const TilesetSettings& settings);

struct LevelMesh {
  LatticeMesh mesh;  // Not empty; with normals in world space.
  double error_bound = 0;
};

// Returns one binary glTF in metres, see levels_glb(). A level is shown while the error of the next
// one is more than a pixel on a screen of 1080 lines; the coarsest one always.
[[nodiscard]] std::string whole_levels_glb(std::span<const LevelMesh> levels,
                                           const DatasetInfo& info,
                                           MeshCodec codec = MeshCodec::kNone);

}  // namespace multitetra
