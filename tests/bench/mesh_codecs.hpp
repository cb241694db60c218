// Meshes as other software sends them: simplified by meshoptimizer, as bytes of Draco or of
// meshoptimizer's own codec, and decoded.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "tests/bench/plain_mesh.hpp"

namespace multitetra {

// Positions have so many bits over the bounding box, in both codecs.
inline constexpr int kPeerBits = 14;

struct EncodedMesh {
  std::uint64_t bytes = 0;
  std::function<void()> decode;  // To positions and triangles in memory. Throws when it fails.
};

// The edgebreaker method at the speed that this project's tiles have.
[[nodiscard]] EncodedMesh encoded_by_draco(const PlainMesh& mesh);

// Whether this program was built with meshoptimizer, which the others require.
[[nodiscard]] bool has_meshoptimizer();
[[nodiscard]] std::string meshoptimizer_version();
// Vertices and triangles in meshoptimizer's order, its index and vertex codecs, and zstd on top, as
// its documentation advises for transmission.
[[nodiscard]] EncodedMesh encoded_by_meshoptimizer(const PlainMesh& mesh);
// With an absolute error, which meshoptimizer takes for a target and does not bound.
[[nodiscard]] PlainMesh simplified_by_meshoptimizer(const PlainMesh& mesh, double error);

}  // namespace multitetra
