// Stores tiles on disk, so that an interrupted fetch can continue where it stopped.
//
//   TileDiskCache folder("head.tiles");
//   folder.load(tiles);                            // DecodedTileCache tiles, from earlier runs.
//   client.fetch(info, open, on_step, {.tiles = &tiles, .on_tile = ...});  // keep()s it.
//
// Each tile is one file named by its content, "<32 hexadecimal digits>.tile": two lines of text,
// then the payload as received:
//
//   multitetra tile 1
//   lattice 5 cube 4 1 0 0 triangles 812 vertices 410 bytes 957 normals 0
//   <957 bytes>
//
// The cube is written as exponent, x, y, z. Files are written atomically (atomic_file.hpp). Files
// are not trusted: a file that is not a tile, does not decode to its counts, or whose content does
// not match its name is skipped, and the tile is fetched again. Files with other names are ignored.
// Tiles serve any request that needs them, so several requests may share a folder. Files are never
// deleted.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "client/library/client.hpp"
#include "client/library/decoded_tile_cache.hpp"

namespace multitetra {

class TileDiskCache {
 public:
  // Creates the folder if needed. All functions throw std::system_error when the disk fails.
  explicit TileDiskCache(std::filesystem::path folder);

  struct Loaded {
    std::uint64_t tiles = 0;
    std::uint64_t damaged = 0;  // Files that were skipped.
  };
  // Loads and checks tiles until `memory` holds kMaxHeldDigests tiles, as many as a request may
  // name, or `most_triangles`. Starts with the largest files, which save the most bytes.
  Loaded load(DecodedTileCache& memory, std::uint64_t most_triangles) const;

  // Writes a tile that passed its checks. It outlives the process, but not always a power failure.
  void keep(const TileSummary& tile, int lattice_resolution, int normal_bits,
            const std::string& payload) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace multitetra
