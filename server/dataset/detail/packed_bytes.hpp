// A long array of items, packed in pieces and always read as a whole. Each piece is
//
//   u32 size of the packed piece, its codec in the highest four bits | the packed piece
//
// and unpacks to kPieceBytes; the last one to the remaining bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "common/base/result.hpp"

namespace multitetra {

inline constexpr std::size_t kPieceBytes = std::size_t{256} << 10;

// Packs the `size` bytes that `read` returns in pieces; passes the packed pieces to `write`.
void pack_bytes(std::uint64_t size, std::size_t item_bytes,
                const std::function<void(std::uint64_t offset, std::span<std::byte> into)>& read,
                const std::function<void(std::span<const std::byte>)>& write);

// Unpacks exactly into.size() bytes. Returns kDamagedData with the section if that fails.
[[nodiscard]] Result<void> unpack_bytes(const char* section, std::span<const std::byte> packed,
                                        std::span<std::byte> into);

}  // namespace multitetra
