// Encodes the samples of a box as a sample shell.
//
//   const Result<std::vector<std::uint8_t>> bytes = encode_shell(
//       {.samples = SampleBlock<std::uint8_t>{.first = brick, .row = 65, .slice = 65 * 65},
//        .data_samples = {65, 65, 65}, .origin = {128, 64, 0}},
//       {.isovalue = 80.5, .values = ShellValues::kExact});
//
// Decoding gives the surface of marching tetrahedra inside the box at the uniform level of these
// samples, with the vertices of core:
//
//  * exact and lattice-exact shells: the same vertices, bit for bit;
//  * quantized shells: the same triangles, with every vertex moved along its edge by at most
//    displacement_bound(L) of its length, plus rounding to the lattice.
//
// Deterministic on every machine.
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
  // The box's lowest corner, layers included, in grid coordinates divided by the spacing; >= 0.
  std::array<std::int32_t, 3> origin;
  // Layers one sample thick around the data, as in byte 3 of the format, in which the surface
  // closes at the value outside the data. Including them, each axis has 2 .. kMaxShellSamples
  // samples.
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

// Returns the largest displacement of vertices in quantized shells, as a part of their edges:
// 1/2 - 1 / (1 + 2^(1 / L)).
[[nodiscard]] double displacement_bound(int levels_per_octave);

// Encodes successive tiles in memory that it keeps, about 2 MB.
class ShellEncoder {
 public:
  ShellEncoder();
  ~ShellEncoder();
  ShellEncoder(ShellEncoder&&) noexcept;
  ShellEncoder& operator=(ShellEncoder&&) noexcept;

  // Fails with kInvalidArgument for input the format cannot represent: a box too large or off the
  // lattice; active samples that are infinite or, in exact shells, not integers of at most
  // kMaxExactValue; an isovalue that is not finite; lattice-exact shells with more than
  // kMaxExactSteps.
  [[nodiscard]] Result<std::vector<std::uint8_t>> encode(const ShellBox& box,
                                                         const ShellOptions& options);

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

// Encodes a single tile.
[[nodiscard]] inline Result<std::vector<std::uint8_t>> encode_shell(const ShellBox& box,
                                                                    const ShellOptions& options) {
  return ShellEncoder().encode(box, options);
}

}  // namespace multitetra::shell
