#include "server/extraction/detail/level_samples.hpp"

#include <algorithm>
#include <array>
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

// The cells of kSpectrumSpacing steps in a cube that the surface crosses.
class CrossedCells {
 public:
  CrossedCells(const PreparedVolume& volume, const OctreeCube& cube, double isovalue)
      : side_(cube.side() >> kSpectrumExponent),
        low_{cube.x * side_, cube.y * side_, cube.z * side_} {
    crossed_.reserve(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_) *
                     static_cast<std::size_t>(side_));
    for (std::int32_t z = 0; z < side_; ++z) {
      for (std::int32_t y = 0; y < side_; ++y) {
        for (std::int32_t x = 0; x < side_; ++x) {
          const OctreeCube cell = {kSpectrumExponent, low_.x + x, low_.y + y, low_.z + z};
          crossed_.push_back(is_crossed(volume, cell, isovalue));
        }
      }
    }
  }

  // Returns whether one of them, closed, contains a point of the box, whose corners must be grid
  // points in the cube.
  [[nodiscard]] bool any_touches(GridPoint low, GridPoint high) const {
    const auto first = [this](std::int32_t v, std::int32_t begin) {
      return std::max(rounded_up(v, kSpectrumSpacing) - 1 - begin, 0);
    };
    const auto last = [this](std::int32_t v, std::int32_t begin) {
      return std::min((v >> kSpectrumExponent) - begin, side_ - 1);
    };
    for (std::int32_t z = first(low.z, low_.z); z <= last(high.z, low_.z); ++z) {
      for (std::int32_t y = first(low.y, low_.y); y <= last(high.y, low_.y); ++y) {
        for (std::int32_t x = first(low.x, low_.x); x <= last(high.x, low_.x); ++x) {
          if (crossed_[static_cast<std::size_t>(x + side_ * (y + side_ * z))]) return true;
        }
      }
    }
    return false;
  }

 private:
  std::int32_t side_;  // Cells a side.
  GridPoint low_;      // The first cell.
  std::vector<bool> crossed_;
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

void LevelSamples::visit_bricks(const OctreeCube& cube, const LevelBox& box,
                                const std::function<void(const BrickPart&)>& visit) const {
  const DatasetInfo& info = volume_.info;
  // An edge lies in a closed cell, so a crossed edge in a crossed cell. Uncrossed cells that share
  // a sample are on one side, as are a brick's samples among them. Void samples have no side.
  std::optional<CrossedCells> cells;
  if (info.void_samples == 0 && cube.exponent >= kSpectrumExponent) {
    cells.emplace(volume_, cube, isovalue_);
  }
  const GridPoint last = box.first + box.count - GridPoint{1, 1, 1};
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
