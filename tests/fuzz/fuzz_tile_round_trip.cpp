// Any non-degenerate triangles survive encoding as a tile: folded, doubled, crossing.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/wire/tile.hpp"
#include "tests/fuzz/require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multitetra;
  if (size < 1) return 0;
  const int speed = data[0] % 10;
  // Three bytes per triangle, each a corner among 4 x 8 x 8 places: few enough that corners often
  // coincide.
  const auto corner = [](std::uint8_t byte) {
    return LatticePoint{byte & 3, byte >> 2 & 7, byte >> 5 & 7};
  };
  std::vector<LatticeTriangle> triangles;
  for (std::size_t at = 1; at + 3 <= size; at += 3) {
    const LatticeTriangle t = {corner(data[at]), corner(data[at + 1]), corner(data[at + 2])};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
  }
  if (triangles.empty()) return 0;
  const LatticeMesh mesh = index_triangles(triangles, 3);
  const EncodedTile tile = encode_tile(mesh, {.exponent = 0, .x = 0, .y = 0, .z = 0}, speed);
  require(decode_tile(*tile.payload, tile.summary, 3).has_value());
  std::vector<UnitVector> directions;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto angle = static_cast<float>(i * data[0]);
    directions.push_back({std::cos(angle), 0, std::sin(angle)});
  }
  const int bits = kMinNormalBits + data[0] % (kMaxNormalBits - kMinNormalBits + 1);
  const EncodedTile shaded = encode_tile(mesh, tile.summary.cube, speed, {directions, bits});
  require(decode_tile(*shaded.payload, shaded.summary, 3, bits).has_value());
  return 0;
}
