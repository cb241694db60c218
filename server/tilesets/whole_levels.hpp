// A surface as a few whole meshes of falling detail, for viewers that take one file.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/request/dataset_info.hpp"
#include "common/request/isosurface_request.hpp"
#include "server/tilesets/cell_tree.hpp"

namespace multitetra {

struct WholeLevel {
  IsosurfaceRequest request;
  // World units: no point of the level is farther from the surface of the samples, nor the other
  // way round; the lattice included.
  double error_bound = 0;
};

// The levels, finest first. The first has the requested error; each next one four times the error
// of the one before, up to a sixteenth of the volume's longest side. All keep the topology.
[[nodiscard]] std::vector<WholeLevel> whole_levels(const DatasetInfo& info,
                                                   const TreeSettings& settings);

struct LevelMesh {
  LatticeMesh mesh;  // With triangles, and normals of the world.
  double error_bound = 0;
};

// One binary glTF in metres, see levels_glb(). A level is shown from where the error of the next
// one is more than a pixel of a screen of 1080 lines; the coarsest always.
[[nodiscard]] std::string whole_levels_glb(std::span<const LevelMesh> levels,
                                           const DatasetInfo& info);

}  // namespace multitetra
