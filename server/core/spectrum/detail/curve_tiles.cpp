#include "server/core/spectrum/detail/curve_tiles.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <stdexcept>

namespace multitetra {
namespace {

// The encoding of a curve in a tile: its place, then its blocks.
//
//   x, y   2 bytes each   the place, relative to the tile's first
//   first  1 byte         as in CurveLayer::Curve
//   count  1 byte
//   blocks 36 bytes each  paper (4 floats), certified (4 floats), flips (eight times 4 bits)
constexpr std::size_t kCurveHead = 6;
constexpr std::size_t kBlockBytes = 36;

std::byte* encode(const CurveBlock& block, std::byte* into) {
  std::memcpy(into, &block.paper, 16);
  std::memcpy(into + 16, &block.certified, 16);
  for (int i = 0; i < 4; ++i) {
    into[32 + i] = static_cast<std::byte>(block.flips[2 * i] | block.flips[2 * i + 1] << 4);
  }
  return into + kBlockBytes;
}

const std::byte* decode(const std::byte* from, CurveBlock& block) {
  std::memcpy(&block.paper, from, 16);
  std::memcpy(&block.certified, from + 16, 16);
  for (int i = 0; i < 4; ++i) {
    const auto two = static_cast<std::uint8_t>(from[32 + i]);
    block.flips[2 * i] = two & 15;
    block.flips[2 * i + 1] = two >> 4;
  }
  return from + kBlockBytes;
}

// Returns whether a complete curve with valid bins begins at `from`.
bool holds_curve(const std::byte* from, const std::byte* end) {
  const auto left = static_cast<std::size_t>(end - from);
  if (left < kCurveHead) return false;
  const auto first = static_cast<std::size_t>(from[4]);
  const auto count = static_cast<std::size_t>(from[5]);
  return count > 0 && 4 * (first + count) <= IsovalueBins::kMaxCount + 3 &&
         left >= kCurveHead + kBlockBytes * count;
}

void encode(GridPoint place, CurveLayer::Curve curve, const CurveBlock* blocks,
            std::vector<std::byte>& bytes) {
  const auto x = static_cast<std::uint16_t>(place.x);
  const auto y = static_cast<std::uint16_t>(place.y);
  const std::size_t begin = bytes.size();
  bytes.resize(begin + kCurveHead + kBlockBytes * curve.count);
  std::byte* into = bytes.data() + begin;
  std::memcpy(into, &x, 2);
  std::memcpy(into + 2, &y, 2);
  into[4] = static_cast<std::byte>(curve.first);
  into[5] = static_cast<std::byte>(curve.count);
  into += kCurveHead;
  for (std::size_t i = 0; i < curve.count; ++i) into = encode(blocks[i], into);
}

}  // namespace

CurveTiles::CurveTiles(GridPoint begin, GridPoint end, GridPoint side, Scratch& scratch)
    : begin_(begin), end_(end), side_(side), scratch_(scratch) {
  const GridPoint extent = end - begin;
  counts_ = {(extent.x + side.x - 1) / side.x, (extent.y + side.y - 1) / side.y, extent.z};
  ranges_.resize(static_cast<std::size_t>(counts_.x) * static_cast<std::size_t>(counts_.y) *
                 static_cast<std::size_t>(counts_.z));
}

std::size_t CurveTiles::index(std::int32_t tile_x, std::int32_t tile_y, std::int32_t k) const {
  return static_cast<std::size_t>(tile_x) +
         static_cast<std::size_t>(counts_.x) *
             (static_cast<std::size_t>(tile_y) +
              static_cast<std::size_t>(counts_.y) * static_cast<std::size_t>(k - begin_.z));
}

std::vector<std::byte> CurveTiles::tile_ranges() const {
  const auto bytes = std::as_bytes(std::span(ranges_));
  return {bytes.begin(), bytes.end()};
}

void CurveTiles::set_tile_ranges(std::span<const std::byte> tile_ranges) {
  if (tile_ranges.size() != ranges_.size() * sizeof(TileRange)) {
    throw std::runtime_error("The number of curve positions differs from the number of tiles.");
  }
  if (!tile_ranges.empty()) std::memcpy(ranges_.data(), tile_ranges.data(), tile_ranges.size());
}

void CurveTiles::put(GridPoint first, const CurveLayer& points) {
  const GridPoint at = first - begin_;
  assert(at.x % side_.x == 0 && at.y % side_.y == 0);
  std::vector<std::byte> bytes;
  for (std::int32_t y = first.y; y < std::min(end_.y, first.y + side_.y); ++y) {
    for (std::int32_t x = first.x; x < std::min(end_.x, first.x + side_.x); ++x) {
      const CurveLayer::Curve curve = points.find(2 * x + 1, 2 * y + 1);
      if (curve.count == 0) continue;
      encode(GridPoint{x, y, 0} - first, curve, points.blocks(curve), bytes);
    }
  }
  if (bytes.empty()) return;
  ranges_[index(at.x / side_.x, at.y / side_.y, first.z)] = {
      .offset = scratch_.put(bytes), .size = static_cast<std::uint32_t>(bytes.size())};
}

void CurveTiles::get(std::int32_t k, CurveLayer& into) const {
  if (k < begin_.z || k >= end_.z) return;
  const GridPoint low = into.low() - begin_;
  const GridPoint high = low + into.extent();  // Exclusive.
  std::vector<std::byte> bytes;
  for (std::int32_t tile_y = std::max(0, low.y) / side_.y;
       tile_y < counts_.y && tile_y * side_.y < high.y; ++tile_y) {
    for (std::int32_t tile_x = std::max(0, low.x) / side_.x;
         tile_x < counts_.x && tile_x * side_.x < high.x; ++tile_x) {
      const TileRange place = ranges_[index(tile_x, tile_y, k)];
      bytes.resize(place.size);
      if (place.size > 0) scratch_.get(place.offset, bytes);
      const std::byte* from = bytes.data();
      const std::byte* const end = from + bytes.size();
      while (from != end) {
        if (!holds_curve(from, end))
          throw std::runtime_error("Curves in a temporary file are damaged.");
        std::uint16_t x = 0;
        std::uint16_t y = 0;
        std::memcpy(&x, from, 2);
        std::memcpy(&y, from + 2, 2);
        CurveLayer::Curve curve = {.offset = 0,
                                   .first = static_cast<std::uint16_t>(from[4]),
                                   .count = static_cast<std::uint16_t>(from[5])};
        from += kCurveHead;
        const GridPoint at = begin_ + GridPoint{tile_x * side_.x + x, tile_y * side_.y + y, 0};
        if (!into.contains(at.x, at.y)) {
          from += kBlockBytes * curve.count;
          continue;
        }
        CurveBlock* const blocks = into.append(curve.count, curve.offset);
        for (std::size_t i = 0; i < curve.count; ++i) from = decode(from, blocks[i]);
        into.at(at.x, at.y) = curve;
      }
    }
  }
}

FinerLayers::FinerLayers(const CurveSource& tiles, const LevelWindow& window)
    : tiles_(tiles),
      low_(window.low - GridPoint{1, 1, 0}),
      extent_(window.extent + GridPoint{1, 1, 0}) {}

FinerCubes FinerLayers::around(std::int32_t k) {
  FinerCubes cubes;
  for (std::int32_t finer = std::max(0, 2 * k - 1); finer <= 2 * k + 2; ++finer) {
    Layer& layer = layers_[static_cast<std::size_t>(finer) % layers_.size()];
    if (layer.k != finer) {
      layer.k = finer;
      layer.curves.reset(low_, extent_);
      tiles_.get(finer, layer.curves);
    }
    cubes.add(finer, layer.curves);
  }
  return cubes;
}

}  // namespace multitetra
