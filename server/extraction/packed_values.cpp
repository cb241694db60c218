#include "server/extraction/packed_values.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <new>
#include <type_traits>

namespace multitetra {
namespace {

template <typename Sample>
bool holds(float value) {
  // NaN and values beyond the range compare as false.
  return value >= static_cast<float>(std::numeric_limits<Sample>::lowest()) &&
         value <= static_cast<float>(std::numeric_limits<Sample>::max()) &&
         static_cast<float>(static_cast<Sample>(value)) == value;
}

// Small differences of either sign become small numbers: 0, -1, 1, -2 become 0, 1, 2, 3.
template <typename Bits>
Bits zigzag(Bits difference) {
  const bool is_negative = difference >> (8 * sizeof(Bits) - 1) != 0;
  const auto doubled = static_cast<Bits>(difference << 1);
  return is_negative ? static_cast<Bits>(~doubled) : doubled;
}

template <typename Bits, typename ToBits>
std::string byte_planes(std::span<const float> values, ToBits to_bits) {
  std::string planes(values.size() * sizeof(Bits), '\0');
  Bits before = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Bits bits = to_bits(values[i]);
    const Bits code = zigzag(static_cast<Bits>(bits - before));
    before = bits;
    for (std::size_t byte = 0; byte < sizeof(Bits); ++byte) {
      planes[byte * values.size() + i] = static_cast<char>(code >> (8 * byte) & 0xFF);
    }
  }
  return planes;
}

// Runs and frequent bytes are nearly all that there is to find, and found several times as fast as
// other repetitions.
std::string deflated(std::string planes) {
  z_stream stream{};
  constexpr int kWindowBits = 15;
  constexpr int kMemoryLevel = 8;
  if (deflateInit2(&stream, 1, Z_DEFLATED, kWindowBits, kMemoryLevel, Z_RLE) != Z_OK) {
    throw std::bad_alloc();
  }
  std::string bytes(deflateBound(&stream, planes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(planes.data());
  stream.avail_in = static_cast<uInt>(planes.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  deflate(&stream, Z_FINISH);
  bytes.resize(stream.total_out);
  deflateEnd(&stream);
  return bytes;
}

}  // namespace

PackedValues packed_values(std::span<const float> values, SampleType type) {
  return visit_type(type, [&]<typename Sample>(const Sample*) -> PackedValues {
    if constexpr (std::is_integral_v<Sample>) {
      using Bits = std::make_unsigned_t<Sample>;
      if (std::all_of(values.begin(), values.end(), holds<Sample>)) {
        const auto to_bits = [](float value) {
          return static_cast<Bits>(static_cast<Sample>(value));
        };
        return {.type = type, .bytes = deflated(byte_planes<Bits>(values, to_bits))};
      }
    }
    const auto to_bits = [](float value) { return std::bit_cast<std::uint32_t>(value); };
    return {.type = SampleType::kF32,
            .bytes = deflated(byte_planes<std::uint32_t>(values, to_bits))};
  });
}

}  // namespace multitetra
