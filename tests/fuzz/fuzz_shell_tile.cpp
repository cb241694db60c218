// Any payload is rejected as a client's tile or gives a mesh that matches the manifest: in the
// cube, with its counts, and manifold where the client does not compare edges.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>

#include "common/codec/shell_decoder.hpp"
#include "common/wire/shell_tile.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using namespace multitetra;

// The first bytes change the promise relative to the payload's header: 7 bytes of the cube, and one
// whose bits select the differences in form and counts.
constexpr std::size_t kPromiseBytes = 8;
// Boxes below the format's limit, for speed.
constexpr std::uint32_t kMaxVertices = 1 << 16;

OctreeCube cube_in(const std::uint8_t* data) {
  const auto number = [data](std::size_t at) { return data[at] | data[at + 1] << 8; };
  return {
      .exponent = data[0] % (kMaxLatticeBits + 1), .x = number(1), .y = number(3), .z = number(5)};
}

void require_manifold(const LatticeMesh& mesh, const MarchedBox& box, const OctreeCube& cube) {
  const DataBorder border = {.low = box.low, .high = box.high};
  const auto for_each = [](std::size_t count, const std::function<void(std::size_t)>& body) {
    for (std::size_t i = 0; i < count; ++i) body(i);
  };
  const TileInCube tile = {.mesh = &mesh, .cube = cube, .marched = box};
  const MeshTopology counted = merged_tiles({&tile, 1}, mesh.resolution, border, for_each).topology;
  require(counted == topology(mesh, border));
  require(counted.is_sound());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < kPromiseBytes) return 0;
  const OctreeCube cube = cube_in(data);
  const unsigned changes = data[7];
  const std::string_view payload(reinterpret_cast<const char*>(data) + kPromiseBytes,
                                 size - kPromiseBytes);
  shell::ShellHeader header;
  const auto* const bytes = data + kPromiseBytes;
  const bool has_header =
      read_shell_header(bytes, payload.size(), header) == shell::ShellStatus::kOk;
  if (has_header && max_vertices(header) > kMaxVertices) return 0;
  const bool is_quantized = header.values == shell::ShellValues::kQuantized;
  const TileSummary promised = {.cube = cube,
                                .digest = digest_of_bytes(payload),
                                .triangles = header.triangles + (changes & 1U),
                                .vertices = header.vertices + (changes >> 1 & 1U),
                                .bytes = static_cast<std::uint32_t>(payload.size())};
  const ShellTileForm form = {
      .lattice_resolution = header.lattice_resolution + static_cast<int>(changes >> 2 & 1U),
      .finest_spacing = std::int32_t{1}
                        << (header.spacing_exponent + static_cast<int>(changes >> 3 & 1U)),
      .shell = {.values = header.values,
                .levels_per_octave = is_quantized ? header.levels_per_octave : 0}};
  const Result<LatticeMesh> mesh = decode_shell_tile(payload, promised, form);
  if (!mesh) {
    require(mesh.error().code == ErrorCode::kDamagedData);
    return 0;
  }
  require(has_header && (changes & 15U) == 0);
  require(mesh->triangles.size() == promised.triangles &&
          mesh->vertices.size() == promised.vertices);
  require(std::all_of(mesh->vertices.begin(), mesh->vertices.end(),
                      [&](const LatticePoint& p) { return cube.contains(p, mesh->resolution); }));
  if (const auto box = marched_box(payload)) require_manifold(*mesh, *box, cube);
  return 0;
}
