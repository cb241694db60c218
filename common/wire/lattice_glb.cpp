#include "common/wire/lattice_glb.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "common/base/json.hpp"
#include "common/wire/detail/glb.hpp"
#include "common/wire/detail/scene_writer.hpp"
#include "common/wire/draco_primitive.hpp"

namespace multitetra {
namespace {

std::array<LatticePoint, 2> lattice_bounds(const LatticeMesh& mesh) {
  LatticePoint low = mesh.vertices.front();
  LatticePoint high = low;
  for (const LatticePoint& p : mesh.vertices) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  return {low, high};
}

std::string meshopt_glb(const LatticeMesh& mesh, const Vec3& grid_step, const SurfaceName& name) {
  const double delta = 1.0 / static_cast<double>(1 << mesh.resolution);
  PositionedMesh placed{.positions = {}, .triangles = mesh.triangles, .normals = mesh.normals};
  placed.positions.reserve(mesh.vertices.size());
  for (const LatticePoint& p : mesh.vertices) {
    placed.positions.push_back(  // Below 2^24: exact as floats.
        {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)});
  }
  SceneWriter scene(MeshCodec::kMeshopt);
  scene.add({.name = name, .mesh = &placed}, 0,
            {delta * grid_step[0], delta * grid_step[1], delta * grid_step[2]},
            /*has_exact_positions=*/true);
  return std::move(scene).file();
}

}  // namespace

std::string lattice_glb(const LatticeMesh& mesh, const OctreeCube& cube, const Vec3& grid_step,
                        const SurfaceName& name, CellCodec codec) {
  if (codec == CellCodec::kMeshopt) return meshopt_glb(mesh, grid_step, name);
  nlohmann::json json = empty_gltf();
  if (mesh.triangles.empty()) return glb_beginning(json, 0);
  const DracoPrimitive draco = encode_draco_primitive(mesh, cube);
  const auto [low, high] = lattice_bounds(mesh);
  constexpr const char* kDraco = "KHR_draco_mesh_compression";
  const auto accessor = [](int component, std::uint32_t count, const char* type) {
    return nlohmann::json{{"componentType", component}, {"count", count}, {"type", type}};
  };
  constexpr int kUnsignedInt = 5125;
  constexpr int kFloat = 5126;
  json["extensionsUsed"] = {kDraco};
  json["extensionsRequired"] = {kDraco};
  json["buffers"] = {{{"byteLength", draco.bytes.size()}}};
  json["bufferViews"] = {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", draco.bytes.size()}}};
  json["accessors"] = {accessor(kUnsignedInt, 3 * draco.triangles, "SCALAR"),
                       accessor(kFloat, draco.points, "VEC3")};
  json["accessors"][1]["min"] = {low.x, low.y, low.z};
  json["accessors"][1]["max"] = {high.x, high.y, high.z};
  nlohmann::json attributes = {{"POSITION", 1}};
  nlohmann::json ids = {{"POSITION", draco.position_id}};
  if (!mesh.normals.empty()) {
    json["accessors"].push_back(accessor(kFloat, draco.points, "VEC3"));
    attributes["NORMAL"] = 2;
    ids["NORMAL"] = draco.normal_id;
  }
  json["materials"] = {surface_material(color_of(name, 0))};
  json["meshes"] = {{{"primitives",
                      {{{"attributes", attributes},
                        {"indices", 0},
                        {"material", 0},
                        {"extensions", {{kDraco, {{"bufferView", 0}, {"attributes", ids}}}}}}}}}};
  // Column-major: scales lattice steps to lengths and converts z-up to y-up.
  const double delta = 1.0 / static_cast<double>(1 << mesh.resolution);
  const double x = delta * grid_step[0];
  const double y = delta * grid_step[1];
  const double z = delta * grid_step[2];
  json["nodes"] = {{{"mesh", 0}, {"matrix", {x, 0, 0, 0, 0, 0, -y, 0, 0, z, 0, 0, 0, 0, 0, 1}}}};
  name_node(json["nodes"][0], name);
  json["scenes"][0]["nodes"] = {0};
  const std::size_t padded = (draco.bytes.size() + 3) / 4 * 4;
  std::string file = glb_beginning(json, padded);
  file += draco.bytes;
  file.resize(file.size() + padded - draco.bytes.size(), '\0');
  return file;
}

}  // namespace multitetra
