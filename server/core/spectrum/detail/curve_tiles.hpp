// The error curves of one level's cube centers, stored in tiles until the next level reads them.
//
// The cube center (2i + 1, 2j + 1, 2k + 1), in units of the level's spacing, has the place (i, j)
// in layer k. A tile is a rectangle of one layer. Memory: 16 bytes a tile. The curves are in the
// scratch without loss, 36 bytes for four bins.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "server/core/framework/grid.hpp"
#include "server/core/spectrum/detail/error_curve.hpp"
#include "server/core/spectrum/detail/level_wavefront.hpp"
#include "server/core/spectrum/spectrum_inputs.hpp"

namespace multitetra {

class CurveSource {
 public:
  virtual ~CurveSource() = default;
  // Adds to `into` the curves of layer k at its places. Throws std::runtime_error if damaged.
  virtual void get(std::int32_t k, CurveLayer& into) const = 0;
};

class CurveTiles : public CurveSource {
 public:
  // Covers the places and layers begin ... end - 1 in tiles of side.x * side.y places. The scratch
  // must outlive this object.
  CurveTiles(GridPoint begin, GridPoint end, GridPoint side, Scratch& scratch);

  // Return the scratch ranges of all tiles as bytes, and restore them for tiles whose bytes are
  // already in a scratch. set_tile_ranges throws std::runtime_error if the size does not match the
  // tiles.
  [[nodiscard]] std::vector<std::byte> tile_ranges() const;
  void set_tile_ranges(std::span<const std::byte> tile_ranges);

  // Stores layer `first.z` of the tile that begins at the place `first`, given a layer of the
  // level's points. Call at most once for each tile; concurrent calls for different tiles are safe.
  void put(GridPoint first, const CurveLayer& points);

  void get(std::int32_t k, CurveLayer& into) const override;

 private:
  struct TileRange {
    std::uint64_t offset = 0;
    std::uint32_t size = 0;  // 0 for a tile without curves, or one not yet written.
    std::uint32_t reserved = 0;
  };
  [[nodiscard]] std::size_t index(std::int32_t tile_x, std::int32_t tile_y, std::int32_t k) const;

  GridPoint begin_;
  GridPoint end_;
  GridPoint side_;
  GridPoint counts_;
  Scratch& scratch_;
  std::vector<TileRange> ranges_;
};

// A cache of the finer level's layers around a step, loaded on demand.
class FinerLayers {
 public:
  // Serves a level that computes the points of `window`. The tiles must outlive this object.
  FinerLayers(const CurveSource& tiles, const LevelWindow& window);
  // Returns the cubes that step k needs.
  [[nodiscard]] FinerCubes around(std::int32_t k);

 private:
  struct Layer {
    std::int32_t k = -1;
    CurveLayer curves;
  };
  const CurveSource& tiles_;
  GridPoint low_;
  GridPoint extent_;
  std::array<Layer, 4> layers_;
};

}  // namespace multitetra
