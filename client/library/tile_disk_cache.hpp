// Stores tiles on disk, so that an interrupted fetch can continue where it stopped.
//
//   TileDiskCache folder("head.tiles");
//    folder.load(tiles);                            // DecodedTileCache tiles, from earlier runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "client/library/client.hpp"
#include "client/library/decoded_tile_cache.hpp"

namespace multitetra {

class TileDiskCache {
 public:
  // Creates the folder if it does not exist. This and the functions below throw std::system_error
  // when the disk fails.
  explicit TileDiskCache(std::filesystem::path folder);

  struct Loaded {
    std::uint64_t tiles = 0;
    std::uint64_t damaged = 0;  // Files that were skipped.
  };
  // Loads and checks tiles until `memory` holds kMaxHeldDigests tiles, as many as a request may
  // name, or `most_triangles`. Starts with the largest files, which save the most bytes.
  Loaded load(DecodedTileCache& memory, std::uint64_t most_triangles) const;

  // Writes a tile that passed its checks. The tile survives the end of the process; a power failure
  // may leave it damaged.
  void keep(const TileSummary& tile, int lattice_resolution, int normal_bits,
            const std::string& payload) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace multitetra
