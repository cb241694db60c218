// The result of decoding a sample shell. Has the layout of LatticePoint and TriangleIndices,
// without including their headers.
#pragma once

#include <stdint.h>

namespace multitetra::shell {

// Lattice coordinates.
struct ShellVertex {
  int32_t x = 0;
  int32_t y = 0;
  int32_t z = 0;
};

// Vertex indices, oriented towards low values.
struct ShellTriangle {
  uint32_t corners[3] = {};
};

}  // namespace multitetra::shell
