// Decodes sample shells to the surface in their box.
//
//   ShellHeader header;
//   if (read_shell_header(bytes, size, header) != ShellStatus::kOk) ...
//   std::vector<ShellVertex> vertices(header.vertices);
//   std::vector<ShellTriangle> triangles(header.triangles);
//   auto decoder = std::make_unique<ShellDecoder>();   // 0.8 MB: keep it for the next tile
//   if (decoder->decode(bytes, size, vertices.data(), triangles.data()) != ShellStatus::kOk) ...
//
// Arbitrary bytes either fail or give a mesh whose indices are below the number of vertices and
// whose vertices lie on edges of the box. Time and memory are bounded by the box, at most 64^3
// cells. The decoder allocates nothing and does not use the standard library. Deterministic on
// every machine.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "common/codec/detail/crossed_edges.hpp"
#include "common/codec/detail/level_scale.hpp"
#include "common/codec/detail/magnitude_coder.hpp"
#include "common/codec/detail/marching.hpp"
#include "common/codec/detail/row_bits.hpp"
#include "common/codec/detail/shell_model.hpp"
#include "common/codec/detail/sign_coder.hpp"
#include "common/codec/shell_format.hpp"
#include "common/codec/shell_mesh.hpp"

namespace multitetra::shell {

class ShellDecoder {
 public:
  // Requires arrays of the sizes the header declares. Their content is undefined after a failure.
  [[nodiscard]] ShellStatus decode(const uint8_t* bytes, size_t size, ShellVertex* vertices,
                                   ShellTriangle* triangles);

 private:
  template <typename Magnitudes, typename Kept, typename Cuts>
  bool decode_slices(RangeDecoder& coder, const ShellHeader& header, const Magnitudes& magnitudes,
                     const Kept& kept, const Cuts& cuts, ShellVertex* vertices,
                     ShellTriangle* triangles);

  SignBlocks blocks_;
  BitField signs_;
  BitField present_;
  ShellModel model_;
  CrossedEdges edges_;
  SampleRings rings_;
  LevelScale scale_;
  Marching marching_;
};

}  // namespace multitetra::shell
