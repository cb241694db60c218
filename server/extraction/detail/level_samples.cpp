#include "server/extraction/detail/level_samples.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <span>

#include "server/core/spectrum/crossed_octants.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {
namespace {

constexpr std::int32_t kBrick = BrickLayout::kSampleSide;

std::int32_t rounded_up(std::int32_t value, std::int32_t spacing) {
  return (value + spacing - 1) / spacing;
}

// Returns the cells of kSpectrumSpacing steps that contain grid points from `low` to `high`, both
// in the cube; only cells inside the cube.
CellSpan cells_around(const OctreeCube& cube, GridPoint low, GridPoint high) {
  const std::int32_t side = cube.side() >> kSpectrumExponent;
  const auto first = [side](std::int32_t v, std::int32_t position) {
    return std::max(rounded_up(v, kSpectrumSpacing) - 1, position * side);
  };
  const auto last = [side](std::int32_t v, std::int32_t position) {
    return std::min(v >> kSpectrumExponent, (position + 1) * side - 1);
  };
  return {.first = {first(low.x, cube.x), first(low.y, cube.y), first(low.z, cube.z)},
          .last = {last(high.x, cube.x), last(high.y, cube.y), last(high.z, cube.z)}};
}

// The cells of kSpectrumSpacing steps that the surface crosses, among those in a cube that contain
// grid points from `low` to `high`.
class CrossedCells {
 public:
  CrossedCells(const PreparedVolume& volume, const OctreeCube& cube, GridPoint low, GridPoint high,
               double isovalue)
      : cube_(cube), cells_(cells_around(cube, low, high)) {
    visit(cells_, [&](GridPoint cell) {
      crossed_.push_back(is_crossed(volume, {kSpectrumExponent, cell.x, cell.y, cell.z}, isovalue));
      return false;
    });
  }

  // Returns whether a crossed cell, including its border, contains a point from `low` to `high`.
  // Requires points in the range above.
  [[nodiscard]] bool any_touches(GridPoint low, GridPoint high) const {
    const GridPoint extent = cells_.last - cells_.first + GridPoint{1, 1, 1};
    return visit(cells_around(cube_, low, high), [&](GridPoint cell) {
      const GridPoint at = cell - cells_.first;
      return bool{crossed_[static_cast<std::size_t>(at.x + extent.x * (at.y + extent.y * at.z))]};
    });
  }

 private:
  // Visits the cells until `look` returns true; returns whether it did.
  template <typename Look>
  static bool visit(const CellSpan& cells, const Look& look) {
    for (std::int32_t z = cells.first.z; z <= cells.last.z; ++z) {
      for (std::int32_t y = cells.first.y; y <= cells.last.y; ++y) {
        for (std::int32_t x = cells.first.x; x <= cells.last.x; ++x) {
          if (look(GridPoint{x, y, z})) return true;
        }
      }
    }
    return false;
  }

  OctreeCube cube_;
  CellSpan cells_;
  std::vector<bool> crossed_;  // By cell of cells_, x fastest.
};

}  // namespace

std::optional<LevelBox> level_box(const DatasetInfo& info, const OctreeCube& cube,
                                  std::int32_t spacing) {
  const std::int32_t cells = cube.side() / spacing;
  LevelBox box;
  std::array<std::int32_t, 3> first{};
  std::array<std::int32_t, 3> count{};
  const std::array<std::int32_t, 3> position = {cube.x, cube.y, cube.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t low = position[axis] * cells;
    const std::int32_t high = low + cells;
    first[axis] = std::max(low, rounded_up(info.margin, spacing));
    const std::int32_t last = std::min(high, (info.margin + info.dims[axis] - 1) / spacing);
    if (last < first[axis]) return std::nullopt;
    count[axis] = last - first[axis] + 1;
    const bool has_low = info.outside && first[axis] > low;
    const bool has_high = info.outside && last < high;
    if (has_low) box.layers |= 1U << (2 * axis);
    if (has_high) box.layers |= 2U << (2 * axis);
    if (count[axis] + (has_low ? 1 : 0) + (has_high ? 1 : 0) < 2) return std::nullopt;
  }
  box.first = {first[0], first[1], first[2]};
  box.count = {count[0], count[1], count[2]};
  return box;
}

bool LevelSamples::may_be_crossed(const OctreeCube& cube) const {
  // For coarse levels of remote datasets, fetching the ranges of all samples does not pay off.
  if (spacing_ >= kSpectrumSpacing || cube.exponent < kSpectrumExponent) return true;
  return is_crossed(volume_, cube, isovalue_);
}

std::optional<LevelBox> LevelSamples::crossed_part(const OctreeCube& cube,
                                                   const LevelBox& box) const {
  const bool is_seen = spacing_ < kSpectrumSpacing && cube.exponent >= kSpectrumExponent &&
                       volume_.info.void_samples == 0;
  if (!is_seen) return box;
  const auto cells = crossed_cells(volume_, cube, isovalue_);
  if (!cells) return std::nullopt;
  const std::int32_t a_cell = kSpectrumSpacing / spacing_;  // The spacing divides it.
  LevelBox part;
  // Whether there are two samples along the axis, layers included.
  const auto cut = [&](int axis, std::int32_t GridPoint::*coordinate) {
    const std::int32_t low = a_cell * cells->first.*coordinate;
    const std::int32_t high = a_cell * (cells->last.*coordinate + 1);
    const std::int32_t first = std::max(box.first.*coordinate, low);
    const std::int32_t last = std::min(box.last().*coordinate, high);
    part.first.*coordinate = first;
    part.count.*coordinate = last - first + 1;
    const std::uint32_t low_layer = 1U << (2 * axis);
    const std::uint32_t high_layer = 2U << (2 * axis);
    if (low < first) part.layers |= box.layers & low_layer;
    if (high > last) part.layers |= box.layers & high_layer;
    const std::uint32_t layers = part.layers >> (2 * axis) & 3U;
    return part.count.*coordinate + std::popcount(layers) >= 2;
  };
  const bool has_cells = cut(0, &GridPoint::x) && cut(1, &GridPoint::y) && cut(2, &GridPoint::z);
  return has_cells ? std::optional(part) : std::nullopt;
}

void LevelSamples::visit_bricks(const OctreeCube& cube, const LevelBox& box,
                                const std::function<void(const BrickPart&)>& visit) const {
  const DatasetInfo& info = volume_.info;
  // An edge lies in a closed cell, so a crossed edge in a crossed cell. Uncrossed cells that share
  // a sample are on one side, as are a brick's samples among them. Void samples have no side.
  std::optional<CrossedCells> cells;
  if (info.void_samples == 0 && cube.exponent >= kSpectrumExponent) {
    cells.emplace(volume_, cube, spacing_ * box.first, spacing_ * box.last(), isovalue_);
  }
  const GridPoint last = box.last();
  const auto brick_of = [&](std::int32_t k) { return (k * spacing_ - info.margin) / kBrick; };
  const auto first_in = [&](std::int32_t brick, std::int32_t first) {
    return std::max(rounded_up(brick * kBrick + info.margin, spacing_), first);
  };
  const auto last_in = [&](std::int32_t brick, std::int32_t end) {
    return std::min((brick * kBrick + kBrick - 1 + info.margin) / spacing_, end);
  };
  BrickPart part;
  for (std::int32_t z = brick_of(box.first.z); z <= brick_of(last.z); ++z) {
    for (std::int32_t y = brick_of(box.first.y); y <= brick_of(last.y); ++y) {
      for (std::int32_t x = brick_of(box.first.x); x <= brick_of(last.x); ++x) {
        part.brick = {x, y, z};
        part.first = {first_in(x, box.first.x), first_in(y, box.first.y), first_in(z, box.first.z)};
        part.last = {last_in(x, last.x), last_in(y, last.y), last_in(z, last.z)};
        part.is_needed = !cells || cells->any_touches(spacing_ * part.first, spacing_ * part.last);
        visit(part);
      }
    }
  }
}

void LevelSamples::add_bricks(const OctreeCube& cube, const LevelBox& box,
                              std::vector<std::size_t>& bricks) const {
  const BrickLayout layout(volume_.info.dims);
  visit_bricks(cube, box, [&](const BrickPart& part) {
    if (part.is_needed) bricks.push_back(layout.index(part.brick));
  });
}

template <typename Sample>
Sample LevelSamples::sample_near(const OctreeCube& cube, GridPoint point) const {
  const std::int32_t side = cube.side() >> kSpectrumExponent;
  const auto cell = [side](std::int32_t v, std::int32_t position) {
    return std::min(v >> kSpectrumExponent, (position + 1) * side - 1);
  };
  const LevelExtent cells = cell_extent(volume_.info);
  const std::size_t index =
      cells.index({cell(point.x, cube.x), cell(point.y, cube.y), cell(point.z, cube.z)});
  Sample least{};
  std::memcpy(&least, volume_.ranges.bytes().data() + 2 * sizeof(Sample) * index, sizeof(Sample));
  return least;
}

template <typename Sample>
void LevelSamples::read_bricks(const OctreeCube& cube, const LevelBox& box,
                               std::vector<Sample>& into) const {
  const std::int32_t margin = volume_.info.margin;
  const BrickLayout layout(volume_.info.dims);
  visit_bricks(cube, box, [&](const BrickPart& part) {
    const GridPoint extent = part.last - part.first + GridPoint{1, 1, 1};
    const auto row_at = [&](std::int32_t y, std::int32_t z) {
      const GridPoint at = part.first - box.first + GridPoint{0, y, z};
      return into.data() + at.x + box.count.x * (at.y + std::ptrdiff_t{box.count.y} * at.z);
    };
    if (!part.is_needed) {
      const auto fill = sample_near<Sample>(cube, spacing_ * part.first);
      for (std::int32_t z = 0; z < extent.z; ++z) {
        for (std::int32_t y = 0; y < extent.y; ++y) std::fill_n(row_at(y, z), extent.x, fill);
      }
      return;
    }
    const RetainedBytes bytes = volume_.samples->brick(layout.index(part.brick));
    const GridCounts size = layout.extent(part.brick);
    const GridPoint in_brick = spacing_ * part.first - GridPoint{margin + kBrick * part.brick[0],
                                                                 margin + kBrick * part.brick[1],
                                                                 margin + kBrick * part.brick[2]};
    const auto* const samples = reinterpret_cast<const Sample*>(bytes.data());
    for (std::int32_t z = 0; z < extent.z; ++z) {
      for (std::int32_t y = 0; y < extent.y; ++y) {
        const Sample* const from =
            samples + in_brick.x +
            size[0] * ((in_brick.y + spacing_ * y) + size[1] * (in_brick.z + spacing_ * z));
        Sample* const to = row_at(y, z);
        if (spacing_ == 1) {
          std::copy_n(from, extent.x, to);
        } else {
          for (std::int32_t x = 0; x < extent.x; ++x) to[x] = from[spacing_ * x];
        }
      }
    }
  });
}

template <typename Sample>
void LevelSamples::read_coarse(const LevelBox& box, std::vector<Sample>& into) const {
  const LevelExtent all = coarse_extent(volume_.info);
  const std::span<const std::byte> bytes = volume_.coarse.bytes();
  const std::int32_t step = spacing_ / kSpectrumSpacing;
  Sample* to = into.data();
  for (std::int32_t z = 0; z < box.count.z; ++z) {
    for (std::int32_t y = 0; y < box.count.y; ++y) {
      for (std::int32_t x = 0; x < box.count.x; ++x) {
        const std::size_t index = all.index(step * (box.first + GridPoint{x, y, z}));
        std::memcpy(to++, bytes.data() + sizeof(Sample) * index, sizeof(Sample));
      }
    }
  }
}

void LevelSamples::read(const OctreeCube& cube, const LevelBox& box, SampleArray& into) const {
  visit_type(volume_.info.type, [&]<typename Sample>(const Sample*) {
    if (!std::holds_alternative<std::vector<Sample>>(into)) into.emplace<std::vector<Sample>>();
    auto& samples = std::get<std::vector<Sample>>(into);
    samples.resize(static_cast<std::size_t>(box.count.x) * static_cast<std::size_t>(box.count.y) *
                   static_cast<std::size_t>(box.count.z));
    if (spacing_ < kSpectrumSpacing) {
      read_bricks(cube, box, samples);
    } else {
      read_coarse(box, samples);
    }
  });
}

}  // namespace multitetra
