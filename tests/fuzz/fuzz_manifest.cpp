// Manifests of datasets made of objects: as they are, and with the checksum that they should have.
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "server/dataset/checksum.hpp"
#include "server/dataset/objects/manifest.hpp"
#include "tests/fuzz/require.hpp"

namespace {

using namespace multitetra;

void read(std::string_view text) {
  const auto manifest = parse_manifest(text);
  if (!manifest) return;
  const auto again = parse_manifest(manifest_text(*manifest));
  require(again && *again == *manifest);
}

std::string hex(std::uint64_t number) {
  std::string digits(16, '0');
  for (std::size_t i = digits.size(); i-- > 0; number >>= 4) {
    digits[i] = "0123456789abcdef"[number & 15];
  }
  return digits;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  read(text);
  nlohmann::json json = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return 0;
  json.erase("checksum");
  const std::string compact = json.dump();
  json["checksum"] = hex(checksum(std::as_bytes(std::span(compact))));
  read(json.dump());
  return 0;
}
