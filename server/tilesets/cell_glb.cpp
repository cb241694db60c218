#include "server/tilesets/cell_glb.hpp"

#include <cmath>
#include <vector>

#include "common/wire/lattice_glb.hpp"
#include "server/tilesets/tileset_json.hpp"

namespace multitetra {
namespace {

// Turns descent directions of the field in world space into surface normals in grid coordinates.
void turn_to_grid(std::vector<UnitVector>& normals, const Affine& grid_to_world) {
  for (UnitVector& normal : normals) {
    Vec3 turned{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Vec3& column = grid_to_world.columns[axis];
      for (std::size_t row = 0; row < 3; ++row) {
        turned[axis] += column[row] * static_cast<double>(normal[row]);
      }
    }
    const double length = std::hypot(turned[0], turned[1], turned[2]);
    if (!(length > 0)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      normal[axis] = static_cast<float>(turned[axis] / length);
    }
  }
}

}  // namespace

std::string cell_glb(LatticeMesh mesh, const DatasetInfo& info, const OctreeCube& cell,
                     CellCodec codec) {
  turn_to_grid(mesh.normals, grid_to_world(info));
  return lattice_glb(mesh, cell, grid_step_metres(info), surface_name(info), codec);
}

}  // namespace multitetra
