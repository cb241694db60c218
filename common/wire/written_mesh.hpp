// What a mesh file of ours holds, read back from its bytes, as other programs find it: vertices
// are those with equal coordinates.
//
//   const std::string file = mesh_file(mesh, MeshFormat::kStl);
//   require_same(read_back(file, MeshFormat::kStl).front(), mesh);
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/mesh/mesh_checks.hpp"
#include "common/mesh/self_intersections.hpp"
#include "common/wire/mesh_files.hpp"

namespace multitetra {

// What is counted in a file. Edges take half of the time of reading it.
enum class ReadBack { kElements, kTopology, kSelfIntersections };

struct WrittenMesh {
  // Of kElements: triangles and vertices only. All edges of a single triangle count as border
  // edges. Degenerate triangles are counted, but not among the triangles.
  MeshTopology topology = {};
  std::optional<SelfIntersections> self_intersections = {};  // Absent: not counted.

  // Returns whether the surface bounds a solid.
  [[nodiscard]] bool is_closed() const { return topology.is_sound() && topology.border_edges == 0; }
};

// Returns what each surface of a file is: one for each node of a GLB and each object of a 3MF with
// triangles, in order, else one. Takes about 150 bytes of memory per triangle. Throws MeshFileError
// if the bytes are not a file that mesh_file() or scene_glb() makes.
[[nodiscard]] std::vector<WrittenMesh> read_back(std::string_view file, MeshFormat format,
                                                 ReadBack counted = ReadBack::kTopology);

// Throws std::logic_error unless the file has all triangles and vertices of the mesh, which must be
// on distinct places: then it has the same topology.
void require_same(const WrittenMesh& written, const PositionedMesh& mesh);

// Returns what a faithful file of any mesh holds, which may have vertices on equal places.
[[nodiscard]] MeshTopology welded_topology(const PositionedMesh& mesh);
// Throws std::logic_error unless the file has that topology. Files need not hold degenerate
// triangles.
void require_same(const WrittenMesh& written, const MeshTopology& expected);

}  // namespace multitetra
