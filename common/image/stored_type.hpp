// The number types of volume files, and their names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

namespace multitetra {

// The types of samples in files. The first five equal those of SampleType, in the same order.
enum class StoredType { kU8, kI8, kU16, kI16, kF32, kU32, kI32, kU64, kI64, kF64 };

[[nodiscard]] std::size_t bytes_of(StoredType type);
[[nodiscard]] std::string_view name(StoredType type);  // "u8" ... "f64"
[[nodiscard]] std::optional<StoredType> stored_type_from(std::string_view name);
// Parses the type names of C and of file formats: "unsigned short int", "uint16_t", "UInt16",
// "ushort", "unsigned_short", "MET_USHORT". A long has 64 bits.
[[nodiscard]] std::optional<StoredType> stored_type_from_word(std::string_view word);

// Calls action.operator()<Number>() with the C++ type of `type`.
template <typename Action>
decltype(auto) with_number_type(StoredType type, Action&& action) {
  switch (type) {
    case StoredType::kU8:
      return action.template operator()<std::uint8_t>();
    case StoredType::kI8:
      return action.template operator()<std::int8_t>();
    case StoredType::kU16:
      return action.template operator()<std::uint16_t>();
    case StoredType::kI16:
      return action.template operator()<std::int16_t>();
    case StoredType::kF32:
      return action.template operator()<float>();
    case StoredType::kU32:
      return action.template operator()<std::uint32_t>();
    case StoredType::kI32:
      return action.template operator()<std::int32_t>();
    case StoredType::kU64:
      return action.template operator()<std::uint64_t>();
    case StoredType::kI64:
      return action.template operator()<std::int64_t>();
    case StoredType::kF64:
      break;
  }
  return action.template operator()<double>();
}

// Returns a number of this type in host byte order.
[[nodiscard]] inline double number_from(StoredType type, const std::byte* bytes) {
  return with_number_type(type, [bytes]<typename Number>() {
    Number number;
    std::memcpy(&number, bytes, sizeof number);
    return static_cast<double>(number);
  });
}

}  // namespace multitetra
