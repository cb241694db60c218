// Any payload is rejected or decodes to a mesh that matches the manifest, whatever Draco returns.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "common/wire/detail/tile_payload.hpp"
#include "common/wire/tile.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using namespace multitetra;

// The first 21 bytes are the part of the manifest that the payload does not contain: the digest,
// the number of vertices, and the bits of normals.
constexpr std::size_t kPromiseBytes = 21;
constexpr int kNormalBits[] = {0, 8, 9, 10};
// Below kMaxTileTriangles, for speed.
constexpr std::uint32_t kMaxTriangles = 1 << 16;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < kPromiseBytes) return 0;
  TileSummary promised{.cube = {15, 0, 0, 0},
                       .bytes = static_cast<std::uint32_t>(size - kPromiseBytes)};
  std::memcpy(&promised.digest, data, 16);
  std::memcpy(&promised.vertices, data + 16, 4);
  const int normal_bits = kNormalBits[data[20] % 4];
  const std::string_view payload(reinterpret_cast<const char*>(data) + kPromiseBytes,
                                 size - kPromiseBytes);
  const Result<TilePayloadClaims> claims = read_claims(payload);
  if (!claims || claims->triangles > kMaxTriangles) return 0;
  promised.triangles = claims->triangles;
  promised.vertices = std::min(promised.vertices, claims->vertices);
  const Result<LatticeMesh> mesh = decode_tile(payload, promised, 5, normal_bits);
  if (!mesh) {
    require(mesh.error().code == ErrorCode::kDamagedData);
    return 0;
  }
  require(digest(*mesh) == promised.digest);
  require(mesh->normals.size() == (normal_bits == 0 ? 0 : mesh->vertices.size()));
  require(std::all_of(mesh->normals.begin(), mesh->normals.end(), is_unit));
  const EncodedTile again = encode_tile(*mesh, promised.cube, kDefaultEncodingSpeed,
                                        {.directions = mesh->normals, .bits = normal_bits});
  require(decode_tile(*again.payload, again.summary, 5, normal_bits).has_value());
  return 0;
}
