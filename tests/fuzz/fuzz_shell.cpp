// Any bytes, of sample shells and plain boxes, are rejected or decode to a mesh whose indices and
// vertices are in range.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/codec/plain_box.hpp"
#include "common/codec/shell_decoder.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using namespace multitetra::shell;

// Boxes below the format's limit, for speed.
constexpr std::uint32_t kMaxVertices = 1 << 16;

void require_in_box(const ShellHeader& header, const std::vector<ShellVertex>& vertices,
                    const std::vector<ShellTriangle>& triangles) {
  for (const ShellTriangle& triangle : triangles) {
    for (const std::uint32_t corner : triangle.corners) require(corner < header.vertices);
  }
  for (const ShellVertex& vertex : vertices) {
    const std::int32_t at[3] = {vertex.x, vertex.y, vertex.z};
    for (int axis = 0; axis < 3; ++axis) {
      const std::int32_t low = header.origin[axis] * header.steps();
      require(at[axis] >= low && at[axis] <= low + (header.samples[axis] - 1) * header.steps());
    }
  }
}

void march_plain(const std::uint8_t* data, std::size_t size) {
  static const auto marcher = std::make_unique<PlainBoxMarcher>();
  ShellHeader header;
  if (read_plain_header(data, size, header) != ShellStatus::kOk) return;
  if (max_vertices(header) > kMaxVertices) return;
  std::vector<ShellVertex> vertices(max_vertices(header));
  std::vector<ShellTriangle> triangles(max_triangles(header));
  marcher->count(data, header, vertices.data(), triangles.data());
  require(header.vertices <= vertices.size() && header.triangles <= triangles.size());
  vertices.resize(header.vertices);
  triangles.resize(header.triangles);
  require(marcher->decode(data, header, vertices.data(), triangles.data()) == ShellStatus::kOk);
  require_in_box(header, vertices, triangles);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto decoder = std::make_unique<ShellDecoder>();
  march_plain(data, size);
  ShellHeader header;
  if (read_shell_header(data, size, header) != ShellStatus::kOk) return 0;
  require(header.vertices <= max_vertices(header) && header.triangles <= max_triangles(header));
  require(header.raw_begin <= header.range_begin && header.range_begin <= size);
  if (max_vertices(header) > kMaxVertices) return 0;
  std::vector<ShellVertex> vertices(header.vertices);
  std::vector<ShellTriangle> triangles(header.triangles);
  if (decoder->decode(data, size, vertices.data(), triangles.data()) != ShellStatus::kOk) return 0;
  require_in_box(header, vertices, triangles);
  return 0;
}
