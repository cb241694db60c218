#include "common/wire/scene_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "common/image/color_map.hpp"
#include "common/wire/detail/glb.hpp"
#include "common/wire/detail/triangle_normals.hpp"

namespace multitetra {
namespace {

static_assert(std::endian::native == std::endian::little,
              "GLB files are written as the bytes lie in memory: little-endian.");

using Triple = std::array<float, 3>;

// glTF's constants for component types and buffer view targets.
constexpr int kFloat = 5126;
constexpr int kUnsignedInt = 5125;
constexpr int kVertexBuffer = 34962;
constexpr int kIndexBuffer = 34963;

// The red, green and blue of the materials, in this order.
constexpr std::array<std::array<double, 3>, 6> kPartColors = {{{0.8, 0.76, 0.7},
                                                               {0.85, 0.45, 0.35},
                                                               {0.35, 0.6, 0.85},
                                                               {0.45, 0.75, 0.45},
                                                               {0.9, 0.75, 0.35},
                                                               {0.65, 0.5, 0.8}}};

// Returns vertex normals, weighted by the areas of the surrounding triangles.
std::vector<Triple> smooth_normals(const PositionedMesh& mesh) {
  std::vector<Vec3> sums(mesh.positions.size(), Vec3{0, 0, 0});
  for (const TriangleIndices& t : mesh.triangles) {
    const Vec3 area = area_vector(mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]);
    for (const std::uint32_t corner : t) sums[corner] = sum(sums[corner], area);
  }
  std::vector<Triple> normals(sums.size());
  std::transform(sums.begin(), sums.end(), normals.begin(), unit_or_upwards);
  return normals;
}

std::vector<Triple> linear_colors(const PositionedMesh& mesh) {
  std::vector<Triple> colors;
  colors.reserve(mesh.colors.size());
  for (const auto& color : mesh.colors) {
    colors.push_back({linear_light(color[0]), linear_light(color[1]), linear_light(color[2])});
  }
  return colors;
}

std::pair<Triple, Triple> bounds(const std::vector<Triple>& positions) {
  std::pair<Triple, Triple> box(positions.front(), positions.front());
  for (const Triple& position : positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.first[axis] = std::min(box.first[axis], position[axis]);
      box.second[axis] = std::max(box.second[axis], position[axis]);
    }
  }
  return box;
}

// Builds the JSON and the binary chunk, array by array.
class SceneWriter {
 public:
  // `unit` is the length of one unit of the mesh.
  void add(const ScenePart& part, std::size_t color, double unit = 1) {
    const PositionedMesh& mesh = *part.mesh;
    if (mesh.triangles.empty()) return;
    nlohmann::json attributes;
    const auto [low, high] = bounds(mesh.positions);
    attributes["POSITION"] = add_array(mesh.positions, kFloat, "VEC3", kVertexBuffer);
    json_["accessors"].back()["min"] = low;
    json_["accessors"].back()["max"] = high;
    attributes["NORMAL"] = add_array(mesh.normals.empty() ? smooth_normals(mesh) : mesh.normals,
                                     kFloat, "VEC3", kVertexBuffer);
    if (!mesh.colors.empty()) {
      attributes["COLOR_0"] = add_array(linear_colors(mesh), kFloat, "VEC3", kVertexBuffer);
    }
    const bool has_scalars =
        !mesh.scalars.empty() && std::none_of(mesh.scalars.begin(), mesh.scalars.end(),
                                              [](float v) { return std::isnan(v); });
    if (has_scalars) {
      attributes["_SCALAR"] = add_array(mesh.scalars, kFloat, "SCALAR", kVertexBuffer);
    }
    const std::size_t indices = add_array(mesh.triangles, kUnsignedInt, "SCALAR", kIndexBuffer);
    json_["accessors"].back()["count"] = 3 * mesh.triangles.size();
    const std::size_t number = json_["nodes"].size();
    json_["materials"].push_back(named(part, material_of(part, color)));
    json_["meshes"].push_back(named(
        part, {{"primitives",
                {{{"attributes", attributes}, {"indices", indices}, {"material", number}}}}}));
    // Column-major: (x, y, z) -> (x, z, -y), z up to y up.
    json_["nodes"].push_back(
        {{"mesh", number}, {"matrix", {unit, 0, 0, 0, 0, 0, -unit, 0, 0, unit, 0, 0, 0, 0, 0, 1}}});
    name_node(json_["nodes"].back(), part.name);
    json_["scenes"][0]["nodes"].push_back(number);
  }

  void set_world(const PhysicalMeaning& world) {
    nlohmann::json& asset = json_["asset"];
    if (!world.length_unit.empty()) asset["extras"]["length_unit"] = world.length_unit;
    if (world.space != WorldSpace::kUnnamed) asset["extras"]["space"] = name(world.space);
  }

  // Turns the parts added so far into levels of detail of one surface.
  void make_levels(std::span<const LevelOfDetail> levels) {
    nlohmann::json coarser = nlohmann::json::array();
    nlohmann::json coverage = nlohmann::json::array();
    for (std::size_t i = 0; i < levels.size(); ++i) {
      if (i > 0) coarser.push_back(i);
      coverage.push_back(levels[i].screen_coverage);
      json_["nodes"][i]["extras"]["error"] = levels[i].error;
    }
    json_["scenes"][0]["nodes"] = {0};
    if (coarser.empty()) return;
    json_["extensionsUsed"] = {"MSFT_lod"};
    json_["nodes"][0]["extensions"]["MSFT_lod"]["ids"] = std::move(coarser);
    json_["nodes"][0]["extras"]["MSFT_screencoverage"] = std::move(coverage);
  }

  [[nodiscard]] std::string file() && {
    if (!binary_.empty()) json_["buffers"] = {{{"byteLength", binary_.size()}}};
    return glb_beginning(json_, binary_.size()) + binary_;
  }

 private:
  // Returns the index of the accessor.
  template <typename T>
  std::size_t add_array(const std::vector<T>& values, int component, const char* type, int target) {
    static_assert(sizeof(T) % 4 == 0);
    json_["bufferViews"].push_back({{"buffer", 0},
                                    {"byteOffset", binary_.size()},
                                    {"byteLength", values.size() * sizeof(T)},
                                    {"target", target}});
    json_["accessors"].push_back({{"bufferView", json_["bufferViews"].size() - 1},
                                  {"componentType", component},
                                  {"count", values.size()},
                                  {"type", type}});
    binary_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    return json_["accessors"].size() - 1;
  }

  static nlohmann::json named(const ScenePart& part, nlohmann::json what) {
    if (!part.name.text.empty()) what["name"] = part.name.text;
    return what;
  }

  // Vertex colors are multiplied with the base color, which is then white.
  static nlohmann::json material_of(const ScenePart& part, std::size_t color) {
    nlohmann::json material = surface_material();
    auto base = part_color(color);
    if (const auto& own = part.color) {
      base = {linear_light(static_cast<int>(*own >> 16 & 0xFF)),
              linear_light(static_cast<int>(*own >> 8 & 0xFF)),
              linear_light(static_cast<int>(*own & 0xFF))};
    }
    if (!part.mesh->colors.empty()) base = {1, 1, 1};
    material["pbrMetallicRoughness"]["baseColorFactor"] = {base[0], base[1], base[2], 1.0};
    return material;
  }

  nlohmann::json json_ = empty_gltf();
  std::string binary_;
};

}  // namespace

std::array<double, 3> part_color(std::size_t number) {
  return kPartColors[number % kPartColors.size()];
}

std::string scene_glb(std::span<const ScenePart> parts, const PhysicalMeaning& world) {
  SceneWriter scene;
  scene.set_world(world);
  for (std::size_t i = 0; i < parts.size(); ++i) scene.add(parts[i], i);
  return std::move(scene).file();
}

std::string levels_glb(std::span<const LevelOfDetail> levels, double unit_metres) {
  SceneWriter scene;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    assert(!levels[i].mesh->triangles.empty());
    scene.add({.name = {"level_" + std::to_string(i)}, .mesh = levels[i].mesh}, 0, unit_metres);
  }
  if (!levels.empty()) scene.make_levels(levels);
  return std::move(scene).file();
}

}  // namespace multitetra
