// Sample shells: tiles of an isosurface as the samples on both sides of it (narrow band).
//
// At a uniform level of the hierarchy, a marching-tetrahedra surface depends only on which samples
// are above the isovalue and on the values at the ends of crossed edges. A shell stores these for
// one box of cells, and the client runs marching tetrahedra. README.md describes the format and its
// coding in full; the layout is:
//
//   byte     content
//   0        version, 1
//   1        bits 0-1 values: 0 exact, 1 lattice-exact, 2 quantized; bits 2-3 log2 of L, the levels
//            per octave (quantized; else 0); bit 4 some samples are void; bits 5-7 zero
//   2        bits 0-3 lattice resolution r, 1 .. 8; bits 4-7 log2 of the spacing s, 0 .. 15
//   3        bits 0-5 layers beyond the data: x low, x high, y low, y high, z low, z high; 6-7 zero
//   4        3 varints: the box's lowest corner in spacings
//   ...      3 bytes: samples along x, y, z less 2, layers beyond the data included
//   ...      2 varints: vertices, triangles
//   ...      exact: the isovalue (8 bytes, IEEE 754, little endian); if byte 3 is not 0, the value
//            of the layers (4 bytes, IEEE 754)
//   ...      else: 3 varints: level number 1 (signed), the number of levels, the exponent of the
//            unit (signed); if byte 3 is not 0, a varint 2 i + p: the layers' level and side
//   ...      varint: n, bytes of raw bits; then these; the range coder's bytes to the end
//
// A varint has seven bits per byte, lowest first, and bit 7 set if another byte follows; a signed
// one is (v << 1) ^ (v >> 31).
//
// This header and the decoder's headers need only a compiler, not the standard library, so that
// they compile to WebAssembly unchanged.
#pragma once

#include <stddef.h>
#include <stdint.h>

namespace multitetra::shell {

inline constexpr uint8_t kShellVersion = 1;
inline constexpr int kMaxShellSamples = 65;  // Along an axis: 64 cells.
inline constexpr int kMaxSpacingExponent = 15;
// Lattice coordinates are at most 2^20, as in common/mesh/lattice.hpp.
inline constexpr int kMaxShellLatticeBits = 20;
// The maximum lattice steps of an edge in lattice-exact shells, where vertices have corrections.
inline constexpr int kMaxExactSteps = 256;
inline constexpr int kLatticeExactLevels = 8;  // L of lattice-exact shells.
// The maximum number of levels from the least to the greatest magnitude of a tile.
inline constexpr int kMaxLevels = 2560;
// The largest magnitude of exact values: integers that floats can represent.
inline constexpr int32_t kMaxExactValue = 1 << 24;

enum class ShellValues : uint8_t {
  kExact = 0,         // Integers.
  kLatticeExact = 1,  // |v - c| in 8 levels per octave, and a correction for each vertex.
  kQuantized = 2,     // |v - c| in L levels per octave.
};

struct ShellHeader {
  ShellValues values = ShellValues::kExact;
  int levels_per_octave = 0;  // Quantized: 1, 2, 4 or 8. Lattice-exact: 8. Exact: 0.
  bool has_void = false;
  int lattice_resolution = 0;  // r: there are 2^r lattice steps per grid step.
  // The samples are 2^spacing_exponent grid steps apart.
  int spacing_exponent = 0;
  uint32_t layers = 0;     // Bit 2 axis + (0 low, 1 high): layers beyond the data.
  int32_t origin[3] = {};  // The lowest corner, in spacings.
  int samples[3] = {};     // Along the axes, 2 .. kMaxShellSamples, layers included.
  uint32_t vertices = 0;
  uint32_t triangles = 0;

  double isovalue = 0;      // Only in exact shells.
  float layer_value = 0;    // Only in exact shells.
  int32_t first_level = 0;  // Only in others: |v - c| of level 1 is about 2^(first_level / L).
  int32_t levels = 0;       // 1 .. kMaxLevels, including level 0.
  int32_t unit_exponent = 0;
  int32_t layer_level = 0;
  bool layer_is_positive = false;

  size_t raw_begin = 0;  // Offsets into the payload.
  size_t range_begin = 0;

  // Lattice steps between adjacent samples.
  [[nodiscard]] constexpr int32_t steps() const {
    return int32_t{1} << (lattice_resolution + spacing_exponent);
  }
  // Returns 1 if there is a layer beyond the data at the low or high end of the axis, otherwise 0.
  [[nodiscard]] constexpr int layer(int axis, bool high) const {
    return static_cast<int>(layers >> (2 * axis + (high ? 1 : 0)) & 1U);
  }
  // Samples along the axis without layers.
  [[nodiscard]] constexpr int data_samples(int axis) const {
    return samples[axis] - layer(axis, false) - layer(axis, true);
  }
};

// Return the maximum output of decoding `header`: 7 edges per sample, 12 triangles per cell.
[[nodiscard]] constexpr uint32_t max_vertices(const ShellHeader& header) {
  return 7U * static_cast<uint32_t>(header.samples[0] * header.samples[1] * header.samples[2]);
}
[[nodiscard]] constexpr uint32_t max_triangles(const ShellHeader& header) {
  return 12U * static_cast<uint32_t>((header.samples[0] - 1) * (header.samples[1] - 1) *
                                     (header.samples[2] - 1));
}

enum class ShellStatus : uint8_t {
  kOk = 0,
  kUnknownVersion = 1,
  kBadHeader = 2,    // A field is out of range, or the bytes end in the header.
  kBadContents = 3,  // The bytes end too early or too late, or the counts differ from the header's.
};

// Parses and checks everything before the first stream. The counts of an accepted header are at
// most max_vertices() and max_triangles().
[[nodiscard]] ShellStatus read_shell_header(const uint8_t* bytes, size_t size, ShellHeader& header);

}  // namespace multitetra::shell
