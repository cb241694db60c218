// Several surfaces in one file: binary glTF 2.0 with a node, a mesh and a material for each.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "common/mesh/mesh.hpp"

namespace multitetra {

// The color of a surface among several: red, green and blue, 0 to 1 in linear light.
[[nodiscard]] std::array<double, 3> part_color(std::size_t number);

struct ScenePart {
  // The name of its node, mesh and material; empty: none.
  std::string name = {};
  const PositionedMesh* mesh = nullptr;  // Not null; one without triangles has no node.
};

// The bytes of the whole file. Each node has a matrix that turns z-up into glTF's y-up; the
// positions themselves are unchanged. A mesh without normals gets smooth normals of its triangles;
// its colors become COLOR_0, in linear light as glTF requires; and its scalars _SCALAR where every
// vertex has one, as glTF has no NaN. Materials are double-sided, those of several parts have
// different colors. Throws std::system_error beyond glTF's 4 GiB.
[[nodiscard]] std::string scene_glb(std::span<const ScenePart> parts);

struct LevelOfDetail {
  const PositionedMesh* mesh = nullptr;  // Not null, with triangles.
  double error = 0;                      // Metres.
  // A part of the screen's area, 0 to 1: hidden where smaller.
  double screen_coverage = 0;
};

// One surface at decreasing level of detail, finest first, each a node "level_0" and so on
// (MSFT_lod): viewers without support for levels show the finest. Otherwise as scene_glb();
// `unit_metres` is the number of metres of a unit of the meshes. Every node has its error in metres
// in its extras ("error").
[[nodiscard]] std::string levels_glb(std::span<const LevelOfDetail> levels, double unit_metres);

}  // namespace multitetra
