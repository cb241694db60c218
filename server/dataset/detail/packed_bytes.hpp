// A long run of items, packed in pieces, which is always read as a whole. Each piece is
//
//   u32 size of what follows, its codec in the highest four bits | the packed piece
//
// and unpacks to kPieceBytes, the last one to what is left.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/base/result.hpp"

namespace multitetra {

inline constexpr std::size_t kPieceBytes = std::size_t{256} << 10;

// Packs `size` bytes, which `read` gives in pieces; `write` gets the packed ones in order.
void pack_bytes(std::uint64_t size, std::size_t item_bytes,
                const std::function<void(std::uint64_t offset, std::span<std::byte> into)>& read,
                const std::function<void(std::span<const std::byte>)>& write);

// Exactly into.size() bytes. Returns what is wrong with `packed`, a part of that section.
[[nodiscard]] Result<void> unpack_bytes(const char* section, std::span<const std::byte> packed,
                                        std::span<std::byte> into);

}  // namespace multitetra
