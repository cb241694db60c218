#include "common/wire/scene_file.hpp"

#include <array>
#include <cassert>
#include <string>
#include <utility>

#include "common/wire/detail/scene_writer.hpp"

namespace multitetra {
namespace {

// The red, green and blue of the materials, in this order.
constexpr std::array<std::array<double, 3>, 6> kPartColors = {{{0.8, 0.76, 0.7},
                                                               {0.85, 0.45, 0.35},
                                                               {0.35, 0.6, 0.85},
                                                               {0.45, 0.75, 0.45},
                                                               {0.9, 0.75, 0.35},
                                                               {0.65, 0.5, 0.8}}};

}  // namespace

std::array<double, 3> part_color(std::size_t number) {
  return kPartColors[number % kPartColors.size()];
}

std::string scene_glb(std::span<const ScenePart> parts, const PhysicalMeaning& world,
                      MeshCodec codec) {
  SceneWriter scene(codec);
  scene.set_world(world);
  for (std::size_t i = 0; i < parts.size(); ++i) scene.add(parts[i], i);
  return std::move(scene).file();
}

std::string levels_glb(std::span<const LevelOfDetail> levels, double unit_metres, MeshCodec codec) {
  SceneWriter scene(codec);
  const UnitLengths unit = {unit_metres, unit_metres, unit_metres};
  for (std::size_t i = 0; i < levels.size(); ++i) {
    assert(!levels[i].mesh->triangles.empty());
    scene.add({.name = {"level_" + std::to_string(i)}, .mesh = levels[i].mesh}, 0, unit);
  }
  if (!levels.empty()) scene.make_levels(levels);
  return std::move(scene).file();
}

}  // namespace multitetra
