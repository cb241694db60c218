#include "common/image/stored_type.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "common/base/enum_names.hpp"
#include "common/base/text.hpp"

namespace multitetra {
namespace {

constexpr EnumNames<StoredType, 10> kNames = {
    {"u8", "i8", "u16", "i16", "f32", "u32", "i32", "u64", "i64", "f64"}};

}  // namespace

std::size_t bytes_of(StoredType type) {
  constexpr std::array<std::size_t, 10> kBytes = {1, 1, 2, 2, 4, 4, 4, 8, 8, 8};
  return kBytes[static_cast<std::size_t>(type)];
}

std::string_view name(StoredType type) { return kNames.of(type); }

std::optional<StoredType> stored_type_from(std::string_view name) { return kNames.find(name); }

std::optional<StoredType> stored_type_from_word(std::string_view written) {
  std::string word = lower_case(written);
  std::replace(word.begin(), word.end(), '_', ' ');
  const auto take = [&](std::string_view prefix) {
    const bool is_there = word.starts_with(prefix);
    if (is_there) word.erase(0, prefix.size());
    return is_there;
  };
  (void)take("met ");
  (void)take("signed ");
  const bool is_unsigned = take("unsigned ") || take("u");
  for (const std::string_view end : {" int", " t"}) {
    if (word.ends_with(end)) word.erase(word.size() - end.size());
  }
  constexpr std::array<std::pair<std::string_view, StoredType>, 14> kSigned = {
      {{"char", StoredType::kI8},
       {"int8", StoredType::kI8},
       {"short", StoredType::kI16},
       {"int16", StoredType::kI16},
       {"int", StoredType::kI32},
       {"int32", StoredType::kI32},
       {"long", StoredType::kI64},
       {"longlong", StoredType::kI64},
       {"long long", StoredType::kI64},
       {"int64", StoredType::kI64},
       {"float", StoredType::kF32},
       {"float32", StoredType::kF32},
       {"double", StoredType::kF64},
       {"float64", StoredType::kF64}}};
  for (const auto& [name, type] : kSigned) {
    if (name != word) continue;
    if (!is_unsigned) return type;
    if (type == StoredType::kI8) return StoredType::kU8;
    if (type == StoredType::kI16) return StoredType::kU16;
    if (type == StoredType::kI32) return StoredType::kU32;
    if (type == StoredType::kI64) return StoredType::kU64;
  }
  return std::nullopt;
}

}  // namespace multitetra
