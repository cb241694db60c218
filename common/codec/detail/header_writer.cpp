#include "common/codec/detail/header_writer.hpp"

#include <bit>
#include <cmath>
#include <string>
#include <utility>

namespace multitetra::shell {

namespace {

void put_varint(std::vector<std::uint8_t>& bytes, std::uint32_t value) {
  for (; value >= 128; value >>= 7) bytes.push_back(static_cast<std::uint8_t>(value | 128U));
  bytes.push_back(static_cast<std::uint8_t>(value));
}

void put_signed_varint(std::vector<std::uint8_t>& bytes, std::int32_t value) {
  put_varint(bytes, static_cast<std::uint32_t>(value) << 1 ^
                        static_cast<std::uint32_t>(value < 0 ? -1 : 0));
}

template <typename Bits>
void put_bits(std::vector<std::uint8_t>& bytes, Bits bits) {
  for (std::size_t i = 0; i < sizeof(Bits); ++i) {
    bytes.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
  }
}

}  // namespace

Result<ShellHeader> header_for(const ShellBox& box, const ShellOptions& options) {
  ShellHeader header;
  header.values = options.values;
  header.lattice_resolution = options.lattice_resolution;
  header.spacing_exponent = options.spacing_exponent;
  if (options.lattice_resolution < 1 || options.lattice_resolution > 8 ||
      options.spacing_exponent < 0 || options.spacing_exponent > kMaxSpacingExponent) {
    return not_encodable("A sample shell has lattice resolutions 1 to 8 and spacings 2^0 to 2^15");
  }
  const int levels = options.levels_per_octave;
  switch (options.values) {
    case ShellValues::kExact:
      break;
    case ShellValues::kLatticeExact:
      header.levels_per_octave = kLatticeExactLevels;
      if (header.steps() > kMaxExactSteps) {
        return not_encodable("A lattice-exact sample shell has at most 256 lattice steps an edge");
      }
      break;
    case ShellValues::kQuantized:
      header.levels_per_octave = levels;
      if (levels != 1 && levels != 2 && levels != 4 && levels != 8) {
        return not_encodable("A quantized sample shell has 1, 2, 4 or 8 levels an octave");
      }
      break;
  }
  if (box.layers >= 64) return not_encodable("A box has six sides");
  header.layers = box.layers;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const std::int32_t data = box.data_samples[i];
    const std::int32_t most =
        kMaxShellSamples - header.layer(axis, false) - header.layer(axis, true);
    const std::int32_t samples = data + header.layer(axis, false) + header.layer(axis, true);
    const std::int64_t end = (std::int64_t{box.origin[i]} + samples - 1) * header.steps();
    if (data < 1 || data > most || samples < 2 || box.origin[i] < 0 ||
        end > std::int64_t{1} << kMaxShellLatticeBits) {
      return not_encodable("A sample shell has 2 to 65 samples a side, on the lattice");
    }
    header.samples[axis] = samples;
    header.origin[axis] = box.origin[i];
  }
  header.isovalue = options.isovalue;
  const double limit = options.values == ShellValues::kExact ? kMaxExactValue - 1 : 0x1p1000;
  if (!(std::abs(options.isovalue) <= limit)) {
    return not_encodable("The isovalue of a sample shell is finite, of an exact one below 2^24");
  }
  if (header.layers != 0) {
    if (!std::isfinite(box.layer_value))
      return not_encodable("Layers beyond the data have a finite value");
    header.layer_value = box.layer_value;
    header.layer_is_positive = static_cast<double>(box.layer_value) > options.isovalue;
  }
  return header;
}

std::vector<std::uint8_t> written_header(const ShellHeader& header, std::size_t raw_size) {
  std::vector<std::uint8_t> bytes;
  bytes.push_back(kShellVersion);
  const int log2_levels = header.values == ShellValues::kQuantized
                              ? std::countr_zero(static_cast<unsigned>(header.levels_per_octave))
                              : 0;
  bytes.push_back(static_cast<std::uint8_t>(static_cast<int>(header.values) | log2_levels << 2 |
                                            (header.has_void ? 16 : 0)));
  bytes.push_back(
      static_cast<std::uint8_t>(header.lattice_resolution | header.spacing_exponent << 4));
  bytes.push_back(static_cast<std::uint8_t>(header.layers));
  for (const std::int32_t low : header.origin) put_varint(bytes, static_cast<std::uint32_t>(low));
  for (const int samples : header.samples) bytes.push_back(static_cast<std::uint8_t>(samples - 2));
  put_varint(bytes, header.vertices);
  put_varint(bytes, header.triangles);
  if (header.values == ShellValues::kExact) {
    put_bits(bytes, std::bit_cast<std::uint64_t>(header.isovalue));
    if (header.layers != 0) put_bits(bytes, std::bit_cast<std::uint32_t>(header.layer_value));
  } else {
    put_signed_varint(bytes, header.first_level);
    put_varint(bytes, static_cast<std::uint32_t>(header.levels));
    put_signed_varint(bytes, header.unit_exponent);
    if (header.layers != 0) {
      put_varint(bytes, static_cast<std::uint32_t>(2 * header.layer_level) |
                            (header.layer_is_positive ? 1U : 0U));
    }
  }
  put_varint(bytes, static_cast<std::uint32_t>(raw_size));
  return bytes;
}

}  // namespace multitetra::shell
