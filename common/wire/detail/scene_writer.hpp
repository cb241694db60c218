// Builds a binary glTF file, surface by surface.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "common/base/json.hpp"
#include "common/base/vec3.hpp"
#include "common/dataset/physical_meaning.hpp"
#include "common/request/mesh_codec.hpp"
#include "common/wire/detail/glb.hpp"
#include "common/wire/scene_file.hpp"

namespace multitetra {

struct PositionSteps;

// Lengths along x, y and z of one unit of a mesh's positions in the file's unit.
using UnitLengths = std::array<double, 3>;

// Returns whether every edge has two triangles with opposite directions.
[[nodiscard]] bool is_closed(const PositionedMesh& mesh);

class SceneWriter {
 public:
  explicit SceneWriter(MeshCodec codec) : codec_(codec) {}

  // Adds a node that converts z-up to y-up, see scene_glb(). `color` is the part's place among the
  // colors of parts. With kMeshopt, positions are rounded unless `has_exact_positions`.
  void add(const ScenePart& part, std::size_t color, const UnitLengths& unit = {1, 1, 1},
           bool has_exact_positions = false);
  void set_world(const PhysicalMeaning& world);
  // Turns the parts added so far into levels of detail of one surface.
  void make_levels(std::span<const LevelOfDetail> levels);
  [[nodiscard]] std::string file() &&;

 private:
  // An array's elements as glTF describes them.
  struct Elements {
    std::span<const std::byte> bytes;
    int component = 0;  // glTF's constant of the component type.
    const char* type = "VEC3";
    std::size_t stride = 0;
    bool is_normalized = false;
    const char* filter = nullptr;  // Of EXT_meshopt_compression.
  };

  // Return the index of the accessor.
  std::size_t add_attribute(const Elements& elements);
  std::size_t add_triangles(const PositionedMesh& mesh);
  std::size_t add_accessor(std::size_t count, int component, const char* type);
  std::size_t add_positions(const PositionedMesh& mesh, const Vec3& origin);
  std::size_t add_positions(const PositionSteps& rounded);
  std::size_t add_normals(const PositionedMesh& mesh);
  std::size_t add_colors(const PositionedMesh& mesh);
  // Appends the bytes of a view; `packed` are those of EXT_meshopt_compression, if it is used.
  void add_view(std::span<const std::byte> bytes, int target);
  void add_packed_view(std::string_view packed, std::size_t stride, std::size_t count,
                       nlohmann::json extension, int target);
  void add_node(const ScenePart& part, std::size_t color, const nlohmann::json& attributes,
                std::size_t indices, const nlohmann::json& matrix);

  // Declares that the last mesh, whose accessors these are, bounds a solid (EXT_mesh_manifold).
  void mark_manifold(const nlohmann::json& positions, std::size_t indices);

  MeshCodec codec_;
  nlohmann::json json_ = empty_gltf();
  std::string binary_;
  // The unpacked size of all views, with EXT_meshopt_compression.
  std::size_t unpacked_bytes_ = 0;
};

}  // namespace multitetra
