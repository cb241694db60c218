#include "common/codec/shell_format.hpp"

namespace multitetra::shell {

namespace {

// Reads bytes from the front; after the end it returns zeros and fails.
class HeaderReader {
 public:
  HeaderReader(const uint8_t* bytes, size_t size) : bytes_(bytes), size_(size) {}

  uint32_t byte() {
    if (at_ < size_) return bytes_[at_++];
    is_good_ = false;
    return 0;
  }
  // Accepts at most 5 bytes, in the shortest form.
  uint32_t varint() {
    uint32_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      const uint32_t next = byte();
      if (shift == 28 && next > 15) break;
      value |= (next & 127U) << shift;
      if (next < 128) {
        if (next == 0 && shift > 0) break;
        return value;
      }
    }
    is_good_ = false;
    return 0;
  }
  int32_t signed_varint() {
    const uint32_t value = varint();
    return static_cast<int32_t>(value >> 1 ^ (0U - (value & 1U)));
  }
  template <typename Number, typename Bits>
  Number number() {
    Bits bits = 0;
    for (size_t i = 0; i < sizeof(Bits); ++i) bits |= static_cast<Bits>(byte()) << (8 * i);
    Number result = 0;
    static_assert(sizeof(result) == sizeof(bits));
    __builtin_memcpy(&result, &bits, sizeof(bits));
    return result;
  }

  [[nodiscard]] size_t at() const { return at_; }
  [[nodiscard]] bool is_good() const { return is_good_; }

 private:
  const uint8_t* bytes_;
  size_t size_;
  size_t at_ = 0;
  bool is_good_ = true;
};

// False for NaN.
template <typename Number>
bool is_within(Number value, Number low, Number high) {
  return value >= low && value <= high;
}

bool read_modes(HeaderReader& in, ShellHeader& header) {
  const uint32_t values = in.byte();
  header.values = static_cast<ShellValues>(values & 3U);
  header.has_void = (values & 16U) != 0;
  const uint32_t log2_levels = values >> 2 & 3U;
  if ((values & 3U) > 2 || (values & 0xe0U) != 0) return false;
  if (header.values != ShellValues::kQuantized && log2_levels != 0) return false;
  header.levels_per_octave = header.values == ShellValues::kQuantized      ? 1 << log2_levels
                             : header.values == ShellValues::kLatticeExact ? kLatticeExactLevels
                                                                           : 0;
  const uint32_t scales = in.byte();
  header.lattice_resolution = static_cast<int>(scales & 15U);
  header.spacing_exponent = static_cast<int>(scales >> 4);
  header.layers = in.byte();
  return is_within(header.lattice_resolution, 1, 8) && header.layers < 64 &&
         header.lattice_resolution + header.spacing_exponent <= kMaxShellLatticeBits &&
         (header.values != ShellValues::kLatticeExact || header.steps() <= kMaxExactSteps);
}

bool read_box(HeaderReader& in, ShellHeader& header) {
  constexpr uint32_t kLimit = 1U << kMaxShellLatticeBits;
  uint32_t origin[3] = {};
  for (uint32_t& low : origin) low = in.varint();
  for (int axis = 0; axis < 3; ++axis) {
    header.samples[axis] = static_cast<int>(in.byte()) + 2;
    if (header.samples[axis] > kMaxShellSamples || header.data_samples(axis) < 1) return false;
    const auto cells = static_cast<uint32_t>(header.samples[axis] - 1);
    if (origin[axis] > kLimit ||
        (uint64_t{origin[axis]} + cells) * static_cast<uint64_t>(header.steps()) > kLimit) {
      return false;
    }
    header.origin[axis] = static_cast<int32_t>(origin[axis]);
  }
  header.vertices = in.varint();
  header.triangles = in.varint();
  return header.vertices <= max_vertices(header) && header.triangles <= max_triangles(header);
}

bool read_values(HeaderReader& in, ShellHeader& header) {
  if (header.values == ShellValues::kExact) {
    header.isovalue = in.number<double, uint64_t>();
    constexpr double kLimit = kMaxExactValue - 1;
    if (!is_within(header.isovalue, -kLimit, kLimit)) return false;
    if (header.layers == 0) return true;
    header.layer_value = in.number<float, uint32_t>();
    header.layer_is_positive = static_cast<double>(header.layer_value) > header.isovalue;
    return is_within(header.layer_value, -__FLT_MAX__, __FLT_MAX__);
  }
  // Slightly above the largest exponent of doubles.
  constexpr int32_t kMaxExponent = 1100;
  header.first_level = in.signed_varint();
  const uint32_t levels = in.varint();
  header.unit_exponent = in.signed_varint();
  if (!is_within(header.first_level, -8 * kMaxExponent, 8 * kMaxExponent) ||
      !is_within(levels, 1U, uint32_t{kMaxLevels}) ||
      !is_within(header.unit_exponent, -kMaxExponent, kMaxExponent)) {
    return false;
  }
  header.levels = static_cast<int32_t>(levels);
  if (header.layers == 0) return true;
  const uint32_t layer = in.varint();
  header.layer_is_positive = (layer & 1U) != 0;
  header.layer_level = static_cast<int32_t>(layer >> 1);
  // A positive layer is above the isovalue.
  return header.layer_level < header.levels &&
         (header.layer_level > 0 || !header.layer_is_positive);
}

}  // namespace

ShellStatus read_shell_header(const uint8_t* bytes, size_t size, ShellHeader& header) {
  header = {};
  HeaderReader in(bytes, size);
  if (in.byte() != kShellVersion) return ShellStatus::kUnknownVersion;
  if (!read_modes(in, header) || !read_box(in, header) || !read_values(in, header)) {
    return ShellStatus::kBadHeader;
  }
  const uint32_t raw = in.varint();
  header.raw_begin = in.at();
  if (!in.is_good() || raw > size - in.at()) return ShellStatus::kBadHeader;
  header.range_begin = header.raw_begin + raw;
  return ShellStatus::kOk;
}

}  // namespace multitetra::shell
