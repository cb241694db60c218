// Encoded tiles by what they contain, shared by all sessions: a tile that two requests have in
// common is encoded once and lies in memory once.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "common/base/lru_map.hpp"
#include "common/wire/tile.hpp"

namespace multitetra {

// The appearance of tiles in sample shells, which differ from plain triangles.
inline constexpr std::uint64_t kShellAppearance = ~std::uint64_t{0};

// The key of an encoded tile: all that determines its bytes. The digest covers the lattice
// resolution.
struct TileKey {
  ContentDigest digest;
  OctreeCube cube;
  // Identifies what is not geometry (normals); kShellAppearance for a sample shell; else 0.
  std::uint64_t appearance = 0;
  // The same triangles may be what is left of different ones.
  double simplification_bound = 0;
  // Its dataset: not every client may see every dataset.
  std::string dataset = {};

  friend auto operator<=>(const TileKey&, const TileKey&) = default;
};

// Safe to use from several threads at once.
class TileCache {
 public:
  struct Counts {
    std::uint64_t hits = 0;
    std::uint64_t misses = 0;
    std::size_t tiles = 0;
    std::size_t bytes = 0;
  };

  // Keeps the tiles that were used last, of at most `capacity` bytes together.
  explicit TileCache(std::size_t capacity) : tiles_(capacity) {}

  [[nodiscard]] std::optional<EncodedTile> find(const TileKey& key);
  // Without counting as a use.
  [[nodiscard]] bool has_all(std::span<const TileKey> keys) const;
  // A tile without normals of that digest that may be seen.
  using MaySee = std::function<bool(const std::string& dataset, bool is_shell)>;
  struct Found {
    EncodedTile tile;
    bool is_shell = false;
  };
  [[nodiscard]] std::optional<Found> find_by_digest(const ContentDigest& digest,
                                                    const MaySee& may_see);
  void add(const TileKey& key, const EncodedTile& tile);
  [[nodiscard]] Counts counts() const;

 private:
  mutable std::mutex mutex_;  // Guards everything below.
  LruMap<TileKey, EncodedTile> tiles_;
  std::uint64_t hits_ = 0;
  std::uint64_t misses_ = 0;
};

}  // namespace multitetra
