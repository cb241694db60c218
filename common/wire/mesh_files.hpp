// Mesh files for other programs: binary PLY and STL, OBJ, GLB (binary glTF 2.0), Draco, and VTK's
// VTP.
//
// No file moves a vertex by more than the mesh's rounding limits. PLY, OBJ and VTP have 64-bit
// coordinates where floats would. GLB files have a node matrix that converts z-up to glTF's y-up
// and, where necessary, moves the surface to its place. STL and Draco files are refused.
#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/dataset/physical_meaning.hpp"
#include "common/dataset/surface_name.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/mesh_codec.hpp"

namespace multitetra {

// The start of the comments of PLY and OBJ files and of the header of STL files.
inline constexpr std::string_view kMeshFileTitle = "Multi-Tetra isosurface";

// Facts appended to it, for programs that compare the mesh with its volume.
struct MeshFileFacts {
  // ", label NUMBER". The text is a comment of PLY, the object of OBJ and the node of GLB files.
  SurfaceName name = {};
  // ", lattice R": the vertices lie at multiples of 2^-R grid steps.
  std::optional<int> lattice = std::nullopt;
  // ", min_component SAMPLES": removed components with a shorter bounding-box diagonal; 0: none.
  double min_component = 0;
  // The world of the positions, in GLB and 3MF files alone: see scene_file.hpp.
  PhysicalMeaning world = {};
  MeshCodec codec = MeshCodec::kNone;  // Of GLB files.
};

// The coordinates of a mesh do not fit into a format. The text says what would, except that
// programs may also offer to move the mesh by `shift`, "X,Y,Z".
class MeshCoordinatesError : public std::invalid_argument {
 public:
  MeshCoordinatesError(const std::string& text, std::string shift_of_mesh)
      : std::invalid_argument(text), shift(std::move(shift_of_mesh)) {}
  std::string shift;
};

enum class MeshFormat { kPly, kStl, kObj, kGlb, kDrc, kVtp, k3mf };

// Parses "ply", "stl", "obj", "glb", "drc", "vtp" or "3mf", in either case, with or without a dot.
[[nodiscard]] std::optional<MeshFormat> mesh_format_from(std::string_view suffix);
// Returns "model/stl" and so on, for HTTP.
[[nodiscard]] std::string_view media_type(MeshFormat format);
// Returns whether a file can have several surfaces: GLB, 3MF.
[[nodiscard]] bool holds_several(MeshFormat format);
// Returns a notice for what the mesh has and files of this format do not: colors, normals.
[[nodiscard]] std::vector<std::string> left_out_notices(const PositionedMesh& mesh,
                                                        MeshFormat format);

// Returns the bytes of the file. Empty meshes give a valid file without triangles (GLB: a scene
// without a mesh), except DRC, which has no such form and gives no bytes. All formats but STL,
// which has normals of triangles, and 3MF, which has none, include the mesh's normals; without them
// GLB gets smooth normals. GLB has a double-sided material. PLY, GLB (see scene_file.hpp) and VTP
// include scalars and colors; PLY, STL, OBJ, GLB and 3MF include `facts`. DRC is quantized over the
// bounding box, to 20 bits or as many as the rounding limits need. Throws std::system_error if the
// mesh exceeds a limit of the format (GLB: 4 GiB), MeshCoordinatesError if its coordinates do.
[[nodiscard]] std::string mesh_file(const PositionedMesh& mesh, MeshFormat format,
                                    const MeshFileFacts& facts = {});

// Writes a file atomically, see atomic_file.hpp. Throws std::system_error with the file's name.
void write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace multitetra
