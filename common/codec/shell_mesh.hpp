// The result of decoding a sample shell: the same layout as LatticePoint and TriangleIndices,
// without their headers.
#pragma once

#include <stdint.h>

namespace multitetra::shell {

// Lattice coordinates.
struct ShellVertex {
  int32_t x = 0;
  int32_t y = 0;
  int32_t z = 0;
};

// Indices of vertices, in the order that faces the low values.
struct ShellTriangle {
  uint32_t corners[3] = {};
};

}  // namespace multitetra::shell
