// The error curves of one level's cube centres, put aside in tiles until the next level takes them.
//
// The cube centre (2i + 1, 2j + 1, 2k + 1), in units of the level's spacing, has the place (i, j)
// in layer k. A tile is a rectangle of one layer. Memory: 16 bytes a tile; the curves are in the
// scratch, 36 bytes for four bins, to the bit.
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
  // Adds the curves of layer k to `into`, as many of them as it has places for. Throws
  // std::runtime_error when what was put aside is damaged.
  virtual void get(std::int32_t k, CurveLayer& into) const = 0;
};

class CurveTiles : public CurveSource {
 public:
  // For the places and layers begin ... end - 1, in tiles of side x * side y. The scratch must
  // outlive this.
  CurveTiles(GridPoint begin, GridPoint end, GridPoint side, Scratch& scratch);

  // The places of all tiles as bytes, and tiles whose bytes are in a scratch already. Throws
  // std::runtime_error when these are no places of such tiles.
  [[nodiscard]] std::vector<std::byte> places() const;
  void set_places(std::span<const std::byte> places);

  // Puts aside layer `begin.z + layer` of the tile that begins with the place `first`, out of a
  // layer of a level's points. Each tile at most once; different ones from any threads.
  void put(GridPoint first, const CurveLayer& points);

  void get(std::int32_t k, CurveLayer& into) const override;

 private:
  struct Place {
    std::uint64_t offset = 0;
    std::uint32_t size = 0;  // 0 for a tile without curves, or one that was not written.
    std::uint32_t reserved = 0;
  };
  [[nodiscard]] std::size_t index(std::int32_t tile_x, std::int32_t tile_y, std::int32_t k) const;

  GridPoint begin_;
  GridPoint end_;
  GridPoint side_;
  GridPoint counts_;
  Scratch& scratch_;
  std::vector<Place> places_;
};

// The layers of the finer level around the step that a level makes, read when they are first
// needed.
class FinerLayers {
 public:
  // For a level that computes the points of `window`. The tiles must outlive this.
  FinerLayers(const CurveSource& tiles, const LevelWindow& window);
  // What step k needs.
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
