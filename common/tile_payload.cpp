#include "common/tile_payload.hpp"

#include <limits>
#include <string>

namespace multitetra {
namespace {

constexpr std::string_view kHeader("DRACO\2\2\1\1\0\0", 11);
constexpr std::string_view kAttribute("\1\0\5\3", 4);  // One: POSITION, INT32, 3 components.

// Takes values off the front of the payload; the first trouble sticks.
class Walk {
 public:
  explicit Walk(std::string_view payload) : payload_(payload) {}

  void expect(std::string_view wanted, std::string_view what) {
    if (error_) return;
    if (payload_.substr(at_, wanted.size()) != wanted) return stop(what);
    at_ += wanted.size();
  }
  void skip(std::uint64_t bytes, std::string_view what) {
    if (error_) return;
    if (bytes > payload_.size() - at_) return stop(what);
    at_ += static_cast<std::size_t>(bytes);
  }
  std::uint64_t varint(std::string_view what,
                       std::uint64_t limit = std::numeric_limits<std::uint32_t>::max()) {
    std::uint64_t value = 0;
    for (unsigned shift = 0; !error_; shift += 7) {
      if (at_ == payload_.size() || shift > 28) {
        stop(what);
        break;
      }
      const auto byte = static_cast<unsigned char>(payload_[at_++]);
      value |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
      if (byte < 0x80) break;
    }
    if (value > limit) stop(what);
    return error_ ? 0 : value;
  }
  void require(bool holds, std::string_view what) {
    if (!error_ && !holds) stop(what);
  }
  [[nodiscard]] std::size_t remaining() const { return payload_.size() - at_; }
  [[nodiscard]] bool failed() const { return error_; }
  [[nodiscard]] Error error() const {
    return {ErrorCode::kDamagedData,
            "The payload is not a tile's Draco mesh: at byte " + std::to_string(at_) + " of " +
                std::to_string(payload_.size()) + ", expected " + std::string(what_) + "."};
  }

 private:
  void stop(std::string_view what) {
    if (error_) return;
    error_ = true;
    what_ = what;
  }

  std::string_view payload_;
  std::size_t at_ = 0;
  bool error_ = false;
  std::string_view what_;
};

}  // namespace

Result<TilePayloadClaims> read_claims(std::string_view payload) {
  using namespace std::string_view_literals;
  Walk walk(payload);
  walk.expect(kHeader, "an edgebreaker triangle mesh, bitstream 2.2, without metadata");
  walk.expect("\0"sv, "the standard traversal");
  const std::uint64_t vertices = walk.varint("the number of vertices");
  const std::uint64_t triangles = walk.varint("the number of triangles");
  walk.expect("\0"sv, "no attribute with its own connectivity");
  const std::uint64_t symbols = walk.varint("the number of symbols");
  walk.require(vertices <= 3 * triangles, "no more than three vertices a triangle");
  walk.require(symbols <= triangles && triangles <= symbols + symbols / 3,
               "as many symbols as the triangles need");
  const std::uint64_t split_symbols = walk.varint("the number of split symbols");
  walk.require(split_symbols <= symbols, "no more split symbols than symbols");

  const std::uint64_t splits = walk.varint("the number of splits", walk.remaining() / 2);
  for (std::uint64_t i = 0; i < 2 * splits && !walk.failed(); ++i) walk.varint("a split");
  walk.skip((splits + 7) / 8, "a bit for each split");

  const std::uint64_t traversal_bytes = walk.varint("the length of the traversal");
  walk.require(symbols <= 8 * traversal_bytes, "a bit or more for each symbol");
  walk.skip(traversal_bytes, "the traversal");
  walk.skip(1, "the probability of start faces");
  walk.skip(walk.varint("the length of the start faces"), "the start faces");

  walk.expect("\1"sv, "one attribute decoder");
  walk.skip(3, "the attribute decoder's kind");
  walk.expect(kAttribute, "one attribute: POSITION of 3 x INT32");
  walk.expect("\0"sv, "an attribute that is not normalized");
  walk.varint("the attribute's id");
  walk.expect("\1"sv, "integer coding without quantization");
  if (walk.failed()) return tl::unexpected(walk.error());
  return TilePayloadClaims{static_cast<std::uint32_t>(triangles),
                           static_cast<std::uint32_t>(vertices)};
}

}  // namespace multitetra
