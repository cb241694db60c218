// Values as the bytes of messages between a program and its sandboxed process.
//
// Both run the same program, so numbers have its own layout. A struct that is not trivially
// copyable has a function that lists its members:
//
//   inline auto fields(SourceTimes& times) { return std::tie(times.count, times.at, times.unit); }
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

namespace multitetra {

template <typename T>
void pack(std::string& into, const T& value);

namespace detail {

template <typename T>
struct IsOptional : std::false_type {};
template <typename T>
struct IsOptional<std::optional<T>> : std::true_type {};
template <typename T>
struct IsVector : std::false_type {};
template <typename T>
struct IsVector<std::vector<T>> : std::true_type {};

}  // namespace detail

// Appends a value.
template <typename T>
void pack(std::string& into, const T& value) {
  if constexpr (std::is_same_v<T, std::filesystem::path>) {
    pack(into, value.string());
  } else if constexpr (std::is_same_v<T, std::string>) {
    pack(into, std::uint64_t{value.size()});
    into += value;
  } else if constexpr (detail::IsVector<T>::value) {
    pack(into, std::uint64_t{value.size()});
    for (const auto& one : value) pack(into, one);
  } else if constexpr (detail::IsOptional<T>::value) {
    pack(into, value.has_value());
    if (value) pack(into, *value);
  } else if constexpr (std::is_trivially_copyable_v<T>) {
    into.append(reinterpret_cast<const char*>(&value), sizeof(value));
  } else {
    std::apply([&](const auto&... one) { (pack(into, one), ...); },
               fields(const_cast<T&>(value)));  // NOLINT: they are only read.
  }
}

template <typename... T>
[[nodiscard]] std::string packed_values(const T&... values) {
  std::string bytes;
  (pack(bytes, values), ...);
  return bytes;
}

// Takes a value from the beginning of the bytes. Returns false if they end too early. Numbers and
// enumerations may have any value: check them.
template <typename T>
[[nodiscard]] bool unpack(std::string_view& from, T& value) {
  if constexpr (std::is_same_v<T, std::filesystem::path>) {
    std::string text;
    const bool is_whole = unpack(from, text);
    value = std::move(text);
    return is_whole;
  } else if constexpr (std::is_same_v<T, std::string>) {
    std::uint64_t size = 0;
    if (!unpack(from, size) || size > from.size()) return false;
    value = from.substr(0, size);
    from.remove_prefix(size);
    return true;
  } else if constexpr (detail::IsVector<T>::value) {
    std::uint64_t size = 0;
    if (!unpack(from, size) || size > from.size()) return false;  // Each has at least a byte.
    value.clear();
    for (std::uint64_t i = 0; i < size; ++i) {
      if (!unpack(from, value.emplace_back())) return false;
    }
    return true;
  } else if constexpr (detail::IsOptional<T>::value) {
    bool has_value = false;
    if (!unpack(from, has_value)) return false;
    value.reset();
    return !has_value || unpack(from, value.emplace());
  } else if constexpr (std::is_same_v<T, bool>) {
    char byte = 0;
    if (!unpack(from, byte)) return false;
    value = byte != 0;
    return true;
  } else if constexpr (std::is_trivially_copyable_v<T>) {
    if (from.size() < sizeof(value)) return false;
    std::memcpy(static_cast<void*>(&value), from.data(), sizeof(value));
    from.remove_prefix(sizeof(value));
    return true;
  } else {
    return std::apply([&](auto&... one) { return (unpack(from, one) && ...); }, fields(value));
  }
}

// Returns whether the bytes are exactly these values.
template <typename... T>
[[nodiscard]] bool unpack_all(std::string_view from, T&... values) {
  return (unpack(from, values) && ...) && from.empty();
}

}  // namespace multitetra
