#include "server/dataset/objects/object_name.hpp"

#include <openssl/sha.h>

#include <algorithm>

namespace multitetra {
namespace {

constexpr std::string_view kHexDigits = "0123456789abcdef";

}  // namespace

std::string ObjectName::hex() const {
  std::string text;
  for (const std::uint8_t byte : digest) {
    text += kHexDigits[byte >> 4];
    text += kHexDigits[byte & 15];
  }
  return text;
}

std::string ObjectName::key() const {
  const std::string digits = hex();
  return "objects/" + digits.substr(0, 2) + "/" + digits;
}

std::optional<ObjectName> ObjectName::from(std::string_view hex, std::uint64_t size) {
  ObjectName name{.digest = {}, .size = static_cast<std::uint32_t>(size)};
  if (hex.size() != 2 * name.digest.size() || size < 1 || size > kMostObjectBytes) {
    return std::nullopt;
  }
  for (std::size_t i = 0; i < hex.size(); ++i) {
    const std::size_t digit = kHexDigits.find(hex[i]);
    if (digit == std::string_view::npos) return std::nullopt;
    name.digest[i / 2] = static_cast<std::uint8_t>(16U * name.digest[i / 2] + digit);
  }
  return name;
}

ObjectName name_of(std::span<const std::byte> bytes) {
  ObjectName name{.digest = {}, .size = static_cast<std::uint32_t>(bytes.size())};
  SHA256(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), name.digest.data());
  return name;
}

}  // namespace multitetra
