// The names of an enumeration whose values are 0, 1, 2, ...
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace multitetra {

template <typename Value, std::size_t count>
struct EnumNames {
  std::array<std::string_view, count> names;

  [[nodiscard]] constexpr std::string_view of(Value value) const {
    return names[static_cast<std::size_t>(value)];
  }
  // Returns the value of a name, or nullopt.
  [[nodiscard]] constexpr std::optional<Value> find(std::string_view name) const {
    for (std::size_t i = 0; i < count; ++i) {
      if (names[i] == name) return static_cast<Value>(i);
    }
    return std::nullopt;
  }
};

}  // namespace multitetra
