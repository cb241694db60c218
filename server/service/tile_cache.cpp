#include "server/service/tile_cache.hpp"

#include <algorithm>
#include <limits>

namespace multitetra {
namespace {

// Bytes of an entry besides its payload: the summary, and the key in both directions.
constexpr std::size_t kOverhead = 2 * sizeof(TileKey) + sizeof(EncodedTile) + 128;

}  // namespace

std::optional<EncodedTile> TileCache::find(const TileKey& key) {
  const std::lock_guard lock(mutex_);
  const EncodedTile* const found = tiles_.find(key);
  ++(found != nullptr ? hits_ : misses_);
  if (found == nullptr) return std::nullopt;
  return *found;
}

bool TileCache::has_all(std::span<const TileKey> keys) const {
  const std::lock_guard lock(mutex_);
  return std::all_of(keys.begin(), keys.end(),
                     [this](const TileKey& key) { return tiles_.contains(key); });
}

std::optional<TileCache::Found> TileCache::find_by_digest(const ContentDigest& digest,
                                                          const MaySee& may_see) {
  constexpr std::int32_t kMin = std::numeric_limits<std::int32_t>::min();
  const TileKey first = {.digest = digest, .cube = {kMin, kMin, kMin, kMin}, .dataset = {}};
  const std::lock_guard lock(mutex_);
  std::optional<bool> is_shell;
  const EncodedTile* const found = tiles_.find_from(
      first, [&](const TileKey& key) { return key.digest == digest; },
      [&](const TileKey& key) {
        if (key.appearance != 0 && key.appearance != kShellAppearance) return false;
        is_shell = key.appearance == kShellAppearance;
        return may_see(key.dataset, *is_shell);
      });
  ++(found != nullptr ? hits_ : misses_);
  if (found == nullptr) return std::nullopt;
  return Found{.tile = *found, .is_shell = *is_shell};
}

void TileCache::add(const TileKey& key, const EncodedTile& tile) {
  const std::lock_guard lock(mutex_);
  tiles_.add(key, tile, tile.payload->size() + kOverhead);
}

TileCache::Counts TileCache::counts() const {
  const std::lock_guard lock(mutex_);
  return {.hits = hits_, .misses = misses_, .tiles = tiles_.size(), .bytes = tiles_.weight()};
}

}  // namespace multitetra
