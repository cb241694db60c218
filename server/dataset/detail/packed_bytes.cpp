#include "server/dataset/detail/packed_bytes.hpp"

#include <algorithm>
#include <cstring>

#include "server/dataset/brick_codec.hpp"
#include "server/dataset/prepared_format.hpp"

namespace multitetra {

void pack_bytes(std::uint64_t size, std::size_t item_bytes,
                const std::function<void(std::uint64_t offset, std::span<std::byte> into)>& read,
                const std::function<void(std::span<const std::byte>)>& write) {
  std::vector<std::byte> piece;
  for (std::uint64_t done = 0; done < size; done += piece.size()) {
    piece.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kPieceBytes, size - done)));
    read(done, piece);
    const PackedBrick packed = pack_brick(piece, item_bytes);
    const std::uint32_t head = size_with_codec(packed.bytes.size(), packed.codec);
    write(std::as_bytes(std::span(&head, 1)));
    write(packed.bytes);
  }
}

Result<void> unpack_bytes(const char* section, std::span<const std::byte> packed,
                          std::span<std::byte> into) {
  while (!into.empty()) {
    const auto piece = into.first(std::min(kPieceBytes, into.size()));
    into = into.subspan(piece.size());
    std::uint32_t head = 0;
    if (packed.size() < sizeof(head)) return damaged(section, "it ends too early.");
    std::memcpy(&head, packed.data(), sizeof(head));
    packed = packed.subspan(sizeof(head));
    const BrickPlace place{.size_and_codec = head};
    if (place.size() > packed.size() ||
        !unpack_brick(place.codec(), packed.first(place.size()), piece)) {
      return damaged(section, "it cannot be decompressed.");
    }
    packed = packed.subspan(place.size());
  }
  if (!packed.empty()) return damaged(section, "it has bytes after its last piece.");
  return {};
}

}  // namespace multitetra
