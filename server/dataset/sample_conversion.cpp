#include "server/dataset/sample_conversion.hpp"

#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <variant>
#include <vector>

namespace multitetra {
namespace {

template <typename Stored>
void convert_from(const std::byte* bytes, std::span<float> into) {
  for (std::size_t i = 0; i < into.size(); ++i) {
    Stored value;
    std::memcpy(&value, bytes + i * sizeof(Stored), sizeof(Stored));
    into[i] = static_cast<float>(value);
  }
}

std::string_view name_of(StoredType type) {
  constexpr std::array<std::string_view, 10> kNames = {"u8",  "i8",  "u16", "i16", "f32",
                                                       "u32", "i32", "u64", "i64", "f64"};
  return kNames[static_cast<std::size_t>(type)];
}

template <typename Sample>
void resize_to(Samples& samples, std::size_t count) {
  if (!std::holds_alternative<std::vector<Sample>>(samples)) samples = std::vector<Sample>();
  std::get<std::vector<Sample>>(samples).resize(count);
}

}  // namespace

bool is_converted(StoredType stored) { return stored > StoredType::kF32; }

SampleType type_in_memory(StoredType stored) {
  return is_converted(stored) ? SampleType::kF32 : static_cast<SampleType>(stored);
}

void resize(Samples& samples, SampleType type, std::size_t count) {
  switch (type) {
    case SampleType::kU8:
      return resize_to<std::uint8_t>(samples, count);
    case SampleType::kI8:
      return resize_to<std::int8_t>(samples, count);
    case SampleType::kU16:
      return resize_to<std::uint16_t>(samples, count);
    case SampleType::kI16:
      return resize_to<std::int16_t>(samples, count);
    case SampleType::kF32:
      return resize_to<float>(samples, count);
  }
}

std::byte* bytes_of(Samples& samples) {
  return std::visit([](auto& values) { return reinterpret_cast<std::byte*>(values.data()); },
                    samples);
}

void convert(StoredType stored, const std::byte* bytes, std::span<float> into) {
  assert(is_converted(stored));
  switch (stored) {
    case StoredType::kU32:
      return convert_from<std::uint32_t>(bytes, into);
    case StoredType::kI32:
      return convert_from<std::int32_t>(bytes, into);
    case StoredType::kU64:
      return convert_from<std::uint64_t>(bytes, into);
    case StoredType::kI64:
      return convert_from<std::int64_t>(bytes, into);
    case StoredType::kF64:
      return convert_from<double>(bytes, into);
    default:
      return;
  }
}

std::uint64_t make_infinite_void(std::span<float> samples) {
  std::uint64_t infinite = 0;
  for (float& sample : samples) {
    if (!std::isinf(sample)) continue;
    sample = std::numeric_limits<float>::quiet_NaN();
    ++infinite;
  }
  return infinite;
}

void tell_conversion(const Notice& notice, const std::filesystem::path& file, StoredType stored) {
  if (!notice || !is_converted(stored)) return;
  notice("'" + file.string() + "': samples of type " + std::string(name_of(stored)) +
         " become f32, with 24 significant bits.");
}

void tell_infinite(const Notice& notice, const std::filesystem::path& file,
                   std::uint64_t infinite) {
  if (!notice || infinite == 0) return;
  notice("'" + file.string() + "': " + std::to_string(infinite) +
         " samples that are infinite or too large for f32 are void from here on.");
}

}  // namespace multitetra
