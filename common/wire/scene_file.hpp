// Several surfaces in one file: binary glTF 2.0 with a node, a mesh and a material for each.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "common/mesh/mesh.hpp"

namespace multitetra {

// The colour of a surface among several: red, green and blue, 0 to 1 in linear light.
[[nodiscard]] std::array<double, 3> part_color(std::size_t number);

struct ScenePart {
  std::string name = {};                 // Of its node, mesh and material; empty: without.
  const PositionedMesh* mesh = nullptr;  // Not null; one without triangles has no node.
};

// The whole file's bytes. Each node has a matrix that turns z-up into glTF's y-up; the positions
// themselves stay as they are. A mesh has smooth normals of its triangles if it has none; its
// colours as COLOR_0, in linear light as glTF wants it; and its scalars as _SCALAR where every
// vertex has one, as glTF has no NaN. Materials are seen from both sides, those of several parts of
// different colours. Throws std::system_error beyond glTF's 4 GiB.
[[nodiscard]] std::string scene_glb(std::span<const ScenePart> parts);

struct LevelOfDetail {
  const PositionedMesh* mesh = nullptr;  // Not null, with triangles.
  double error = 0;                      // Metres.
  double screen_coverage = 0;            // Of the screen's area, 0 to 1: not shown where smaller.
};

// One surface at falling detail, the finest level first, each a node "level_0" and so on
// (MSFT_lod): who does not know of levels shows the finest. Otherwise as scene_glb(), and
// `unit_metres` metres are what 1 is in the meshes. Every node tells its error in metres in its
// extras ("error").
[[nodiscard]] std::string levels_glb(std::span<const LevelOfDetail> levels, double unit_metres);

}  // namespace multitetra
