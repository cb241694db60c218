// Meshes of other programs: PLY, STL, OBJ, binary glTF, VTK's .vtp. The first byte selects the
// format. A file is rejected with a reason or is a mesh of finite vertices and valid triangles.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "server/certify/mesh_file.hpp"
#include "server/volume/formats/stored_volume.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/support/temporary_folder.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multitetra;
  static const TemporaryFolder folder;
  static constexpr std::array kNames = {"m.ply", "m.stl", "m.obj", "m.glb", "m.vtp", "m.3mf"};
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (bytes.starts_with("DRACO")) return 0;  // fuzz_tile covers Draco's decoder, behind our checks.
  try {
    const TriangleMesh mesh = read_mesh_here(folder.file(kNames[data[0] % kNames.size()], bytes));
    for (const Vec3& vertex : mesh.vertices) {
      require(std::all_of(vertex.begin(), vertex.end(), [](double v) { return std::isfinite(v); }));
    }
    for (const TriangleIndices& triangle : mesh.triangles) {
      for (const std::uint32_t corner : triangle) require(corner < mesh.vertices.size());
    }
  } catch (const VolumeFileError& refused) {
    require(std::string_view(refused.what()).starts_with("Cannot read '"));
  }
  return 0;
}
