// Tiles on the disk, so that a killed fetch can continue where it stopped.
//
//   TileDiskCache folder("head.tiles");
//   folder.load(tiles);                            // DecodedTileCache tiles; what an earlier run left.
//   client.fetch(info, open, on_step, {.tiles = &tiles, .on_tile = ...});  // keep()s it.
//
// One file a tile, named by its content: "<32 hexadecimal digits>.tile", two lines of text and the
// tile's bytes as they travelled:
//
//   multitetra tile 1
//   lattice 5 cube 4 1 0 0 triangles 812 vertices 410 bytes 957
//   <957 bytes>
//
// The cube is written as exponent, x, y, z. A file appears complete or not at all, see
// atomic_file.hpp. Files are as untrusted as a server: a file that is not a tile, whose bytes do
// not decode to its counts, or whose content differs from its name, is skipped, and the tile is
// fetched again. Files with other names are left alone. A tile fits every request that needs it, so
// a folder may serve several; nothing is ever deleted.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "client/library/client.hpp"
#include "client/library/decoded_tile_cache.hpp"

namespace multitetra {

class TileDiskCache {
 public:
  // Makes the folder if there is none. Throws std::system_error (also in the functions below) when
  // the disk fails.
  explicit TileDiskCache(std::filesystem::path folder);

  struct Loaded {
    std::uint64_t tiles = 0;
    std::uint64_t damaged = 0;  // Files that were passed over.
  };
  // Reads and checks tiles until the memory has as many as a request may name (kMaxHeldDigests) or
  // `most_triangles`, the largest files first: they spare the most bytes.
  Loaded load(DecodedTileCache& memory, std::uint64_t most_triangles) const;

  // Writes a tile that passed its checks. The tile stays when the process ends; after a power cut
  // it may be found damaged.
  void keep(const TileSummary& tile, int lattice_resolution, int normal_bits,
            const std::string& payload) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace multitetra
