// The name of an immutable object: what its bytes are, and how many.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace multitetra {

inline constexpr std::uint32_t kMostObjectBytes = std::uint32_t{16} << 20;

struct ObjectName {
  std::array<std::uint8_t, 32> digest{};  // SHA-256 of the bytes.
  std::uint32_t size = 0;                 // 1 to kMostObjectBytes.

  friend auto operator<=>(const ObjectName&, const ObjectName&) = default;

  // 64 lower-case hexadecimal digits, as sha256sum prints them.
  [[nodiscard]] std::string hex() const;
  // Where the object is below its dataset: "objects/", two digits, "/", all digits.
  [[nodiscard]] std::string key() const;
  // nullopt when it is no digest, or no size.
  [[nodiscard]] static std::optional<ObjectName> from(std::string_view hex, std::uint64_t size);
};

[[nodiscard]] ObjectName name_of(std::span<const std::byte> bytes);

}  // namespace multitetra
