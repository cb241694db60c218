#include "common/wire/detail/tile_payload.hpp"

#include <string>

namespace multitetra {
namespace {

constexpr std::string_view kHeader("DRACO\2\2\1\1\0\0", 11);
constexpr std::string_view kStandardTraversal("\0", 1);
constexpr std::string_view kValenceTraversal("\2", 1);
constexpr std::string_view kNoFurtherConnectivity("\0", 1);

// Consumes values from the front of the payload and keeps the first error.
class Walk {
 public:
  explicit Walk(std::string_view payload) : payload_(payload) {}

  bool take(std::string_view wanted) {
    if (payload_.substr(at_, wanted.size()) != wanted) return false;
    at_ += wanted.size();
    return true;
  }
  // Reads a 32-bit number, 7 bits per byte, lowest bits first.
  std::uint32_t varint(std::string_view what) {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 35 && at_ < payload_.size(); shift += 7) {
      const auto byte = static_cast<unsigned char>(payload_[at_++]);
      value |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
      if (byte < 0x80 && value <= 0xFFFFFFFF) return static_cast<std::uint32_t>(value);
    }
    require(false, what);
    return 0;
  }
  void require(bool holds, std::string_view what) {
    if (holds || !failure_.empty()) return;
    failure_ = "the payload is not a tile's Draco mesh: at byte " + std::to_string(at_) + " of " +
               std::to_string(payload_.size()) + ", expected " + std::string(what) + ".";
  }
  [[nodiscard]] const std::string& failure() const { return failure_; }

 private:
  std::string_view payload_;
  std::size_t at_ = 0;
  std::string failure_;
};

}  // namespace

Result<TilePayloadClaims> read_claims(std::string_view payload) {
  Walk walk(payload);
  walk.require(walk.take(kHeader), "an edgebreaker mesh, bitstream 2.2, without metadata");
  walk.require(walk.take(kStandardTraversal) || walk.take(kValenceTraversal),
               "the standard or the valence traversal");
  const std::uint32_t vertices = walk.varint("the number of vertices");
  const std::uint64_t triangles = walk.varint("the number of triangles");
  walk.require(walk.take(kNoFurtherConnectivity), "no attribute with its own connectivity");
  const std::uint64_t symbols = walk.varint("the number of symbols");
  const std::uint64_t split_symbols = walk.varint("the number of split symbols");
  walk.require(vertices <= 3 * triangles, "no more than three vertices a triangle");
  walk.require(symbols <= triangles && triangles <= symbols + symbols / 3,
               "as many symbols as the triangles need");
  walk.require(split_symbols <= symbols, "no more split symbols than symbols");
  if (!walk.failure().empty()) return fail(ErrorCode::kDamagedData, walk.failure());
  return TilePayloadClaims{static_cast<std::uint32_t>(triangles), vertices};
}

}  // namespace multitetra
