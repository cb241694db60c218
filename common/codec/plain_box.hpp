// Marches a box of samples as they lie in memory: the surface of an exact sample shell of the same
// box, for a host that has the samples itself, such as a page that reads prepared files.
//
//   byte     content (little endian)
//   0        version, 2: no sample shell
//   1        type of the samples: 0 u8, 1 i8, 2 u16, 3 i16, 4 f32 (NaN is void)
//   2, 3     as in sample shells: lattice resolution and spacing; layers beyond the data
//   4        3 x i32: the box's lowest corner in spacings
//   16       3 x i32: samples along x, y, z, layers beyond the data included
//   28       2 x u32: vertices, triangles; only decode() needs them
//   36       f32: the value of the layers
//   40       f64: the isovalue
//   48       the samples of the data, x fastest
//
// Like the decoder of sample shells, it allocates nothing, needs only a compiler, is deterministic,
// and either fails or gives a mesh inside the box, for arbitrary bytes.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "common/codec/detail/crossed_edges.hpp"
#include "common/codec/detail/marching.hpp"
#include "common/codec/detail/row_bits.hpp"
#include "common/codec/shell_format.hpp"
#include "common/codec/shell_mesh.hpp"

namespace multitetra::shell {

inline constexpr uint8_t kPlainVersion = 2;
inline constexpr size_t kPlainHeaderBytes = 48;

// Checks the header and the number of bytes; `header` gets its values, and has_void from the
// samples.
[[nodiscard]] ShellStatus read_plain_header(const uint8_t* bytes, size_t size, ShellHeader& header);

class PlainBoxMarcher {
 public:
  // Requires arrays as large as the counts in `header`, from read_plain_header(). kBadContents if
  // the surface has other counts, and then the arrays are undefined.
  [[nodiscard]] ShellStatus decode(const uint8_t* bytes, const ShellHeader& header,
                                   ShellVertex* vertices, ShellTriangle* triangles);

  // Sets the counts in `header`. Requires arrays of max_vertices() and max_triangles() if samples
  // are void; else they may be null.
  void count(const uint8_t* bytes, ShellHeader& header, ShellVertex* vertices,
             ShellTriangle* triangles);

 private:
  void find_signs(const uint8_t* bytes, const ShellHeader& header);
  [[nodiscard]] bool march(const uint8_t* bytes, const ShellHeader& header, ShellVertex* vertices,
                           ShellTriangle* triangles);

  BitField signs_;
  BitField present_;
  CrossedEdges edges_;
  Marching marching_;
};

}  // namespace multitetra::shell
