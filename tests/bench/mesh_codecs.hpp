// Meshes as other software sends them: simplified by meshoptimizer, encoded by Draco or by
// meshoptimizer's own codec, and decoded.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "tests/bench/plain_mesh.hpp"

namespace multitetra {

// The bits of positions over the bounding box, in both codecs.
inline constexpr int kPeerBits = 14;

struct EncodedMesh {
  std::uint64_t bytes = 0;
  std::function<void()> decode;  // Decodes to positions and triangles in memory. Throws on failure.
};

// Uses the edgebreaker method at the speed of this project's tiles.
[[nodiscard]] EncodedMesh encoded_by_draco(const PlainMesh& mesh);

[[nodiscard]] std::string meshoptimizer_version();
// Encodes vertices and triangles in meshoptimizer's order by its index and vertex codecs, then
// zstd, as its documentation recommends for transmission.
[[nodiscard]] EncodedMesh encoded_by_meshoptimizer(const PlainMesh& mesh);
// Simplifies with an absolute error, which meshoptimizer uses as a target and does not bound.
[[nodiscard]] PlainMesh simplified_by_meshoptimizer(const PlainMesh& mesh, double error);

}  // namespace multitetra
