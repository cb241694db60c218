// decode_tile for other languages: a C function in a shared library that the Python package loads.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <string>

#include "common/wire/tile.hpp"

using multitetra::LatticeMesh;
using multitetra::TileSummary;

extern "C" {

// The fields of TileSummary as the conversation has them.
struct MultitetraTile {
  std::uint32_t cube_exponent;
  std::uint32_t cube_x;
  std::uint32_t cube_y;
  std::uint32_t cube_z;
  std::uint64_t digest_high;
  std::uint64_t digest_low;
  std::uint32_t triangles;
  std::uint32_t vertices;
};

// Decodes and checks as decode_tile does. Writes 3 * vertices lattice coordinates, 3 * triangles
// indices and, where normals were asked for, 3 * vertices components. 0; or 1 and the reason, cut
// to `message_bytes` with a 0 at its end. Touches nothing else, whatever the payload and the
// promises are.
int multitetra_decode_tile(const char* payload, std::size_t payload_bytes,
                           const MultitetraTile* promised, int lattice_resolution, int normal_bits,
                           std::int32_t* vertices, std::uint32_t* triangles, float* normals,
                           char* message, std::size_t message_bytes);
}

namespace {

int refuse(const std::string& why, char* message, std::size_t message_bytes) {
  if (message_bytes > 0) {
    const std::size_t size = std::min(why.size(), message_bytes - 1);
    std::memcpy(message, why.data(), size);
    message[size] = '\0';
  }
  return 1;
}

// What parse_server_message makes sure of for the C++ client.
bool is_within_ranges(const MultitetraTile& tile, int lattice_resolution, int normal_bits) {
  constexpr std::uint32_t kBits = multitetra::kMaxLatticeBits;
  if (tile.cube_exponent > kBits || lattice_resolution < multitetra::kMinLatticeResolution ||
      lattice_resolution > multitetra::kMaxLatticeResolution) {
    return false;
  }
  const std::uint32_t places = std::uint32_t{1} << (kBits - tile.cube_exponent);
  const bool has_place = tile.cube_x < places && tile.cube_y < places && tile.cube_z < places;
  const bool has_counts = tile.triangles >= 1 && tile.triangles <= multitetra::kMaxTileTriangles &&
                          tile.vertices >= 3 && tile.vertices <= 3 * tile.triangles;
  const bool has_normals = normal_bits == 0 || (normal_bits >= multitetra::kMinNormalBits &&
                                                normal_bits <= multitetra::kMaxNormalBits);
  return has_place && has_counts && has_normals;
}

TileSummary summary_of(const MultitetraTile& tile, std::size_t payload_bytes) {
  TileSummary summary;
  summary.cube = {.exponent = static_cast<std::int32_t>(tile.cube_exponent),
                  .x = static_cast<std::int32_t>(tile.cube_x),
                  .y = static_cast<std::int32_t>(tile.cube_y),
                  .z = static_cast<std::int32_t>(tile.cube_z)};
  summary.digest = {.high = tile.digest_high, .low = tile.digest_low};
  summary.triangles = tile.triangles;
  summary.vertices = tile.vertices;
  summary.bytes = static_cast<std::uint32_t>(payload_bytes);
  return summary;
}

}  // namespace

int multitetra_decode_tile(const char* payload, std::size_t payload_bytes,
                           const MultitetraTile* promised, int lattice_resolution, int normal_bits,
                           std::int32_t* vertices, std::uint32_t* triangles, float* normals,
                           char* message, std::size_t message_bytes) {
  if (!is_within_ranges(*promised, lattice_resolution, normal_bits)) {
    return refuse("its manifest promises what no tile has", message, message_bytes);
  }
  try {
    const auto mesh =
        multitetra::decode_tile({payload, payload_bytes}, summary_of(*promised, payload_bytes),
                                lattice_resolution, normal_bits);
    if (!mesh) return refuse(mesh.error().text, message, message_bytes);
    for (const auto& vertex : mesh->vertices) {
      *vertices++ = vertex.x;
      *vertices++ = vertex.y;
      *vertices++ = vertex.z;
    }
    for (const auto& triangle : mesh->triangles) {
      triangles = std::copy(triangle.begin(), triangle.end(), triangles);
    }
    for (const auto& normal : mesh->normals) {
      normals = std::copy(normal.begin(), normal.end(), normals);
    }
    return 0;
  } catch (const std::exception& error) {
    return refuse(error.what(), message, message_bytes);
  }
}
