// Several surfaces in one binary glTF 2.0 file, with a node, a mesh and a material each.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/dataset/physical_meaning.hpp"
#include "common/dataset/surface_name.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/mesh_codec.hpp"

namespace multitetra {

// Returns the color of a surface among several: red, green and blue, 0 to 1 in linear light.
[[nodiscard]] std::array<double, 3> part_color(std::size_t number);

struct ScenePart {
  // The name of its node, mesh and material; the node's extras have the label's number ("label").
  // If it has no color, the part_color() of its index among the parts is used.
  SurfaceName name = {};
  // Not null. A mesh without triangles gets no node.
  const PositionedMesh* mesh = nullptr;
};

// Returns the bytes of the file. Each node has a matrix that converts z-up to glTF's y-up;
// where floats would be too coarse for the positions, these are relative to the center of their
// box, to which the matrix moves them. Closed surfaces are marked (EXT_mesh_manifold). Meshes
// without normals get smooth normals. Colors become COLOR_0, in linear light as glTF requires.
// Scalars become _SCALAR if every vertex has one, as glTF has no NaN. Materials are double-sided.
// The asset's extras have what is known of the positions' world: "length_unit" and "space". With
// kMeshopt, positions are rounded to 1 / 65535 of the longest side of their box (unless vertices
// would coincide), by at most position_rounding(), normals to 8 bits and colors to 16. Throws
// std::system_error beyond glTF's 4 GiB, and MeshCoordinatesError (mesh_files.hpp).
[[nodiscard]] std::string scene_glb(std::span<const ScenePart> parts,
                                    const PhysicalMeaning& world = {},
                                    MeshCodec codec = MeshCodec::kNone);
// Returns the largest distance by which kMeshopt rounds a position.
[[nodiscard]] double position_rounding(const PositionedMesh& mesh);

struct LevelOfDetail {
  const PositionedMesh* mesh = nullptr;  // Not null, with triangles.
  double error = 0;                      // In metres.
  // The fraction of the screen's area, 0 to 1, below which it is hidden.
  double screen_coverage = 0;
};

// Returns one surface at decreasing levels of detail, finest first, as nodes "level_0" and so on
// (MSFT_lod); viewers without support for levels show the finest. Otherwise as scene_glb().
// `unit_metres` is the length of one unit of the meshes in metres. Every node has its error in
// metres in its extras ("error").
[[nodiscard]] std::string levels_glb(std::span<const LevelOfDetail> levels, double unit_metres,
                                     MeshCodec codec = MeshCodec::kNone);

}  // namespace multitetra
