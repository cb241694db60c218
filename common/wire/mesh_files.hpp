// Meshes as files other programs read: binary PLY and STL, OBJ, GLB (binary glTF 2.0), Draco, and
// VTK's VTP.
//
// All formats hold float positions in the coordinates of the mesh. GLB files carry a node matrix
// that turns z-up into glTF's y-up; the positions themselves stay as they are.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "common/mesh/mesh.hpp"

namespace multitetra {

// What the comments of PLY and OBJ files and the header of STL files begin with.
inline constexpr std::string_view kMeshFileTitle = "Multi-Tetra isosurface";

// What follows there, for programs that compare the mesh with its volume.
struct MeshFileFacts {
  // ", lattice R": the vertices lie at multiples of 2^-R grid steps.
  std::optional<int> lattice = std::nullopt;
  // ", min_component SAMPLES": components with a shorter bounding-box diagonal were removed. 0:
  // none.
  double min_component = 0;
};

enum class MeshFormat { kPly, kStl, kObj, kGlb, kDrc, kVtp };

// By suffix, letters of either case: "ply", "stl", "obj", "glb", "drc", "vtp", with or without the
// leading dot.
[[nodiscard]] std::optional<MeshFormat> mesh_format_from(std::string_view suffix);
// "model/stl" and so on, for HTTP.
[[nodiscard]] std::string_view media_type(MeshFormat format);

// The whole file's bytes. An empty mesh gives a valid file without triangles wherever the format
// has one: GLB then has a scene without mesh; DRC has none, and no bytes are returned. The
// mesh's normals are in all files but STL, which has those of its triangles; GLB has smooth ones of
// the triangles around a vertex if the mesh has none, and a double-sided material. Scalars and
// colors are in PLY, GLB (see scene_file.hpp) and VTP. DRC is quantized to 20 bits over the
// bounding box. PLY, STL and OBJ files have the facts. Throws std::system_error when the
// mesh exceeds a limit of the format (GLB: 4 GiB).
[[nodiscard]] std::string mesh_file(const PositionedMesh& mesh, MeshFormat format,
                                    const MeshFileFacts& facts = {});

// The file appears whole or not at all, see atomic_file.hpp. Throws std::system_error naming the
// file.
void write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace multitetra
