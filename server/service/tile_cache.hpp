// Encoded tiles by content, shared by all sessions: a tile that several requests have in common is
// encoded and stored once.
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

// The `appearance` of sample shells.
inline constexpr std::uint64_t kShellAppearance = ~std::uint64_t{0};

// The key of an encoded tile: everything that determines its bytes. The digest covers the lattice
// resolution.
struct TileKey {
  ContentDigest digest;
  OctreeCube cube;
  // Identifies the normals; kShellAppearance for a sample shell, 0 for neither.
  std::uint64_t appearance = 0;
  // Part of the key because different surfaces may simplify to the same triangles.
  double simplification_bound = 0;
  // Part of the key because clients may see different datasets.
  std::string dataset = {};

  friend auto operator<=>(const TileKey&, const TileKey&) = default;
};

// Thread-safe.
class TileCache {
 public:
  struct Counts {
    std::uint64_t hits = 0;
    std::uint64_t misses = 0;
    std::size_t tiles = 0;
    std::size_t bytes = 0;
  };

  // Keeps the most recently used tiles, up to `capacity` bytes.
  explicit TileCache(std::size_t capacity) : tiles_(capacity) {}

  [[nodiscard]] std::optional<EncodedTile> find(const TileKey& key);
  // Returns whether all tiles are cached. Does not count as a use.
  [[nodiscard]] bool has_all(std::span<const TileKey> keys) const;
  // Finds a tile without normals by its digest, among those that may be seen.
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
