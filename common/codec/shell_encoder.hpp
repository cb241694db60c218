// Samples of a box -> bytes of a sample shell.
//
//   const Result<std::vector<std::uint8_t>> bytes = encode_shell(
//       {.samples = SampleBlock<std::uint8_t>{.first = brick, .row = 65, .slice = 65 * 65},
//        .data_samples = {65, 65, 65}, .origin = {128, 64, 0}},
//       {.isovalue = 80.5, .values = ShellValues::kExact});
//
// What decodes is the surface that marching tetrahedra give inside the box at the uniform level
// whose samples these are, with the vertices of core:
//
// * exact and lattice-exact shells: bit for bit the vertices of these samples;
// * quantized shells: the same triangles, with every vertex moved along its edge by at most
//   displacement_bound(L) spacings, rounding to the lattice apart.
//
// Same samples, same bytes, on every machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <variant>
#include <vector>

#include "common/base/result.hpp"
#include "common/codec/shell_format.hpp"

namespace multitetra::shell {

// Sample (x, y, z) is first[x + row * y + slice * z].
template <typename Sample>
struct SampleBlock {
  const Sample* first = nullptr;
  std::ptrdiff_t row = 0;
  std::ptrdiff_t slice = 0;
};
using AnySampleBlock =
    std::variant<SampleBlock<std::uint8_t>, SampleBlock<std::int8_t>, SampleBlock<std::uint16_t>,
                 SampleBlock<std::int16_t>, SampleBlock<float>>;

struct ShellBox {
  AnySampleBlock samples;  // NaN is void.
  // The extent of the block; each at least 1.
  std::array<std::int32_t, 3> data_samples;
  // Grid coordinates of the box's lowest corner in spacings, layers included; >= 0.
  std::array<std::int32_t, 3> origin;
  // Layers one sample thick around the data, as in byte 3 of the format: where the surface closes
  // at the value outside of the data. With them each axis has 2 .. kMaxShellSamples samples.
  std::uint32_t layers = 0;
  float layer_value = 0;  // Finite.
};

struct ShellOptions {
  double isovalue = 0;  // Finite.
  ShellValues values = ShellValues::kExact;
  int levels_per_octave = kLatticeExactLevels;  // For quantized shells: 1, 2, 4 or 8.
  int lattice_resolution = 5;
  int spacing_exponent = 0;
};

// The largest displacement of vertices of quantized shells, in spacings along the longest edges
// (cube diagonals): sqrt(3) (1/2 - 1 / (1 + 2^(1 / L))).
[[nodiscard]] double displacement_bound(int levels_per_octave);

// Encodes tiles one after another in memory that it keeps, about 2 MB.
class ShellEncoder {
 public:
  ShellEncoder();
  ~ShellEncoder();
  ShellEncoder(ShellEncoder&&) noexcept;
  ShellEncoder& operator=(ShellEncoder&&) noexcept;

  // kInvalidArgument for what the format has no place for: a box too large or off the lattice;
  // active samples that are infinite or, in exact shells, no integers of at most kMaxExactValue; an
  // isovalue that is not finite; lattice-exact with more than kMaxExactSteps.
  [[nodiscard]] Result<std::vector<std::uint8_t>> encode(const ShellBox& box,
                                                         const ShellOptions& options);

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

// The same for a single tile.
[[nodiscard]] inline Result<std::vector<std::uint8_t>> encode_shell(const ShellBox& box,
                                                                    const ShellOptions& options) {
  return ShellEncoder().encode(box, options);
}

}  // namespace multitetra::shell
