#include "server/core/fine_errors/fine_errors.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>

#include "server/core/errors/own_error.hpp"
#include "server/core/fine_errors/detail/cell_samples.hpp"
#include "server/core/fine_errors/detail/mixed_diamonds.hpp"
#include "server/core/framework/diamond.hpp"
#include "server/core/framework/rounding.hpp"

namespace multitetra {
namespace {

// Grid steps beyond the cube in which errors of spacing 1, 2 and 4 are needed.
constexpr std::array<std::int32_t, kSpectrumExponent> kHaloSteps = {6, 4, 0};

using Float4 = Lanes<float>::Vector;
using Mask = std::int32_t __attribute__((vector_size(16)));
constexpr Mask kLowBits = {1, 2, 4, 8};
constexpr Mask kHighBits = {16, 32, 64, 128};
// Bits of eight points in each of four rows, one byte a row.
struct RowSigns {
  std::uint32_t above = 0;
  std::uint32_t below = 0;
};

RowSigns signs_of_rows(const float* values, std::ptrdiff_t row, float isovalue_below) {
  const Float4 c = all(isovalue_below);
  Mask above{};
  Mask below{};
  for (int y = 0; y < 4; ++y) {
    std::array<Float4, 2> v;
    std::memcpy(v.data(), values + row * y, sizeof(v));
    above |= (((v[0] > c) & kLowBits) | ((v[1] > c) & kHighBits)) << (8 * y);
    below |= (((v[0] <= c) & kLowBits) | ((v[1] <= c) & kHighBits)) << (8 * y);
  }
  const auto joined = [](Mask m) { return static_cast<std::uint32_t>(m[0] | m[1] | m[2] | m[3]); };
  return {.above = joined(above), .below = joined(below)};
}

// Returns the bits of those points low, low + 1, ..., low + 7 that lie in [first, last].
unsigned bits_between(std::int32_t low, std::int32_t first, std::int32_t last) {
  const std::int32_t begin = std::max(0, first - low);
  const std::int32_t end = std::min(kSpectrumSpacing, last - low + 1);
  if (begin >= end) return 0;
  return (1U << end) - (1U << begin);
}

GridPoint low_of(const OctreeCube& cube) {
  return {cube.x << cube.exponent, cube.y << cube.exponent, cube.z << cube.exponent};
}

}  // namespace

FineErrors::FineErrors(const PreparedVolume& volume, const FineErrorsOptions& options,
                       FineArrays& arrays)
    : volume_(volume),
      options_(options),
      isovalue_below_(rounded_down(options.isovalue)),
      threshold_below_(rounded_down(options.largest_threshold)),
      cells_(volume, options.isovalue),
      arrays_(arrays) {
  const GridStepLengths lengths(volume.info.spacing);
  for (int exponent = 0; exponent < kSpectrumExponent; ++exponent) {
    lengths_[static_cast<std::size_t>(exponent)] = diamond_lengths<double>(lengths, exponent);
  }
}

void FineErrors::load(const OctreeCube& cube,
                      const std::function<bool(const OctreeCube&)>& is_wanted) {
  assert(cube.exponent >= kSpectrumExponent && cube.exponent <= kMaxExponent);
  cells_.find(cube, is_wanted);
  if (cells_.support().empty()) return;
  side_ = cube.side();
  origin_ = low_of(cube) - GridPoint{kCell, kCell, kCell};
  row_ = side_ + 2 * kCell;
  slice_ = row_ * row_;
  begin_arrays();
  make_offsets();
  const auto size = static_cast<std::int32_t>(row_);
  CellSamples samples(volume_, origin_, origin_ + GridPoint{size, size, size});
  for (const FineCell& cell : cells_.support()) {
    samples.load_cell(cell.low, arrays_.values.data() + index(cell.low), row_, slice_);
    load_signs(cell);
  }
  for (const FineCell& cell : cells_.support()) {
    if (cell.is_crossed) find_mixed_diamonds(cell);
  }
  for (int exponent = exponent_of(options_.finest_spacing); exponent < kSpectrumExponent;
       ++exponent) {
    compute(exponent);
  }
}

void FineErrors::begin_arrays() {
  const auto size = static_cast<std::size_t>(slice_ * row_);
  if (arrays_.values.size() < size) {
    arrays_.values.resize(size);
    arrays_.errors.resize(size);
  }
  for (BitGrid* bits :
       {&arrays_.above, &arrays_.below, &arrays_.mixed, &arrays_.active, &arrays_.exceeding}) {
    bits->begin(static_cast<std::int32_t>(row_ / kCell));
  }
}

// Computes the array offsets of corners and children; strides depend on the cube's size.
void FineErrors::make_offsets() {
  const auto offset_of = [this](GridPoint p) { return p.x + row_ * p.y + slice_ * p.z; };
  for (std::size_t shape = 0; shape < kDiamonds.size(); ++shape) {
    for (std::size_t i = 0; i < kDiamonds[shape].corners; ++i) {
      offsets_[shape][i] = offset_of(kDiamonds[shape].offsets[i]);
    }
  }
  for (int exponent = 0; exponent < kSpectrumExponent; ++exponent) {
    for (const PointKind kind : {PointKind::kEdge, PointKind::kFace, PointKind::kCube}) {
      for (std::int32_t row = 0; row < 4; ++row) {
        const RowKind& shape = row_kind(kind, row & 1, row >> 1);
        // Children of an edge have half the spacing; at spacing 1 it has none.
        if (!shape.exists || (shape.is_edge && exponent == 0)) continue;
        Children& children =
            children_[static_cast<std::size_t>(exponent)][row_index(kind, {0, row & 1, row >> 1})];
        children.count = 0;
        for (const GridPoint child : shape.children) {
          children.offsets[children.count++] =
              offset_of(child) * (1 << (shape.is_edge ? exponent - 1 : exponent));
        }
      }
    }
  }
}

// ---- bits

std::size_t FineErrors::bits_of(const FineCell& cell) const {
  const GridPoint at = cell.low - origin_;
  return arrays_.above.cell(at.x / kCell, at.y / kCell, at.z / kCell);
}

// Initializes the cell's errors to 0 and computes the signs of its points.
void FineErrors::load_signs(const FineCell& cell) {
  const std::size_t bits = bits_of(cell);
  for (std::int32_t z = 0; z < kCell; ++z) {
    const std::ptrdiff_t at = index(cell.low) + slice_ * z;
    for (std::int32_t y = 0; y < kCell; ++y) {
      std::fill_n(arrays_.errors.begin() + at + row_ * y, kCell, 0.0F);
    }
    if (!cell.is_near) continue;
    const auto rows =
        signs_of_rows(&arrays_.values[static_cast<std::size_t>(at)], row_, isovalue_below_);
    const auto more = signs_of_rows(&arrays_.values[static_cast<std::size_t>(at + 4 * row_)], row_,
                                    isovalue_below_);
    arrays_.above.plane(bits, z) = rows.above | BitPlane{more.above} << 32;
    arrays_.below.plane(bits, z) = rows.below | BitPlane{more.below} << 32;
  }
}

// Handles all spacings and kinds at once: their points are disjoint, so their bits are too.
void FineErrors::find_mixed_diamonds(const FineCell& cell) {
  const std::size_t bits = bits_of(cell);
  const std::array<BitPlane, kCell> mixed = mixed_diamonds(arrays_.above, arrays_.below, bits);
  for (std::int32_t z = 0; z < kCell; ++z) {
    arrays_.mixed.plane(bits, z) = mixed[static_cast<std::size_t>(z)];
  }
}

float FineErrors::error(GridPoint p) const {
  const GridPoint at = p - origin_;
  const std::size_t cell = arrays_.exceeding.cell(at.x / kCell, at.y / kCell, at.z / kCell);
  const int bit = at.x % kCell + kCell * (at.y % kCell);
  if ((arrays_.exceeding.plane(cell, at.z % kCell) >> bit & 1) != 0) {
    return std::numeric_limits<float>::infinity();
  }
  return arrays_.errors[static_cast<std::size_t>(index(p))];
}

std::uint32_t FineErrors::exceeding_neighbours(GridPoint p, std::int32_t step,
                                               const std::array<std::int32_t, 3>& turned) const {
  const GridPoint at = p - origin_;
  // The cube's lower ends lie in the cell of its center, the upper ones possibly in the next.
  const int first = at.x % kCell - step * turned[0];
  const int middle = at.x % kCell;
  const int last = at.x % kCell + step * turned[0];
  std::uint32_t result = 0;
  int place = 0;
  for (std::int32_t k = -1; k <= 1; ++k) {
    for (std::int32_t j = -1; j <= 1; ++j, place += 3) {
      const std::int32_t y = at.y + step * turned[1] * j;
      const std::int32_t z = at.z + step * turned[2] * k;
      const std::size_t cell = arrays_.exceeding.cell(at.x / kCell, y / kCell, z / kCell);
      const BitPlane row = (arrays_.exceeding.plane(cell, z % kCell) >> (8 * (y % kCell)) & 0xFF) |
                           (arrays_.exceeding.plane(cell + 1, z % kCell) >> (8 * (y % kCell)) & 1)
                               << kCell;
      const BitPlane three = (row >> first & 1) | (row >> middle & 1) << 1 | (row >> last & 1) << 2;
      result |= static_cast<std::uint32_t>(three) << place;
    }
  }
  return result;
}

// ---- errors

void FineErrors::compute(int exponent) {
  for (const PointKind kind : {PointKind::kEdge, PointKind::kFace, PointKind::kCube}) {
    for (const FineCell& cell : cells_.support()) {
      if (cell.is_near) compute_kind(cell, exponent, kind);
    }
  }
}

void FineErrors::compute_kind(const FineCell& cell, int exponent, PointKind kind) {
  const std::int32_t step = 1 << exponent;
  const std::int32_t reach = kHaloSteps[static_cast<std::size_t>(exponent)];
  const std::int32_t last = 1 << volume_.info.grid_exponent;
  // Restricted to the needed points inside the grid.
  const auto needed = [&](std::int32_t low, std::int32_t origin) {
    return bits_between(low, std::max(origin + kCell - reach, 0),
                        std::min(origin + kCell + side_ + reach, last));
  };
  const BitPlane needed_in_layer =
      plane_of(needed(cell.low.x, origin_.x), needed(cell.low.y, origin_.y));
  const unsigned layers = needed(cell.low.z, origin_.z);
  const std::size_t bits = bits_of(cell);
  for (std::int32_t z = 0; z < kCell; z += step) {
    const BitPlane points = points_of_kind(kind, z, exponent) & needed_in_layer;
    if ((layers >> z & 1U) == 0 || points == 0) continue;
    const BitPlane mixed = arrays_.mixed.plane(bits, z) & points;
    const BitPlane active = with_children(arrays_.active, bits, z, exponent, kind) & points;
    if ((mixed | active) == 0) continue;
    const BitPlane exceeding =
        active == 0 ? 0 : with_children(arrays_.exceeding, bits, z, exponent, kind) & points;
    arrays_.active.plane(bits, z) |= active;
    arrays_.exceeding.plane(bits, z) |= exceeding;
    compute_points(cell, z, (mixed | active) & ~exceeding, mixed, exponent, kind);
  }
}

// Computes the points of a layer that may have an error but no child above the threshold.
void FineErrors::compute_points(const FineCell& cell, std::int32_t z, BitPlane points,
                                BitPlane mixed, int exponent, PointKind kind) {
  BitPlane active = 0;
  BitPlane exceeding = 0;
  for (BitPlane left = points; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    const GridPoint p = cell.low + GridPoint{i % kCell, i / kCell, z};
    const std::ptrdiff_t at = index(p);
    const GridPoint unit_point = {p.x >> exponent, p.y >> exponent, p.z >> exponent};
    float error = largest_error(
        children_[static_cast<std::size_t>(exponent)][row_index(kind, unit_point)], at);
    if ((mixed >> i & 1U) != 0) error = with_own_error(p, at, exponent, error);
    arrays_.errors[static_cast<std::size_t>(at)] = error;
    active |= static_cast<BitPlane>(error > 0) << i;
    exceeding |= static_cast<BitPlane>(error > threshold_below_) << i;
  }
  const std::size_t bits = bits_of(cell);
  arrays_.active.plane(bits, z) |= active;
  arrays_.exceeding.plane(bits, z) |= exceeding;
}

// Returns the largest error of the children of the point at `at`. None may exceed the threshold.
float FineErrors::largest_error(const Children& children, std::ptrdiff_t at) const {
  float largest = 0;
  for (std::size_t i = 0; i < children.count; ++i) {
    largest = std::max(largest, arrays_.errors[static_cast<std::size_t>(at + children.offsets[i])]);
  }
  return largest;
}

float FineErrors::with_own_error(GridPoint p, std::ptrdiff_t at, int exponent, float below) const {
  DiamondValues<double> d;
  load_diamond(p, at, exponent, d);
  const OwnError own = own_error_of_mixed(d, options_.isovalue);
  const bool is_forbidden = options_.rule == TopologyRule::kPaper ? own.flip : own.critical;
  if (is_forbidden && (1 << exponent) > options_.topology_tolerance) {
    return std::numeric_limits<float>::infinity();
  }
  return options_.error_measure == ErrorMeasure::kPaper
             ? std::max(below, rounded_up(own.displacement))
             : rounded_up(own.certified + static_cast<double>(below));
}

void FineErrors::load_diamond(GridPoint p, std::ptrdiff_t at, int exponent,
                              DiamondValues<double>& d) const {
  const GridPoint unit_point = {p.x >> exponent, p.y >> exponent, p.z >> exponent};
  const std::int32_t last = 1 << (volume_.info.grid_exponent - exponent);
  const std::size_t index = diamond_index(unit_point);
  const auto& lengths = lengths_[static_cast<std::size_t>(exponent)];
  const float* const center = arrays_.values.data() + at;
  const auto value = [&](std::size_t i) {
    return static_cast<double>(center[offsets_[index][i] << exponent]);
  };
  if (std::min({p.x, p.y, p.z}) == 0 ||
      std::max({unit_point.x, unit_point.y, unit_point.z}) == last) {
    return load_at_border(unit_point, last, static_cast<double>(*center), lengths, value, d);
  }
  d.center = static_cast<double>(*center);
  d.corners = kDiamonds[index].corners;
  d.vectors = d.corners / Lanes<double>::kWidth;  // The number of corners is even.
  d.ring_is_open = false;
  d.length = &lengths[index];
  for (std::size_t i = 0; i < d.vectors; ++i) {
    d.value.vectors[i] = Lanes<double>::Vector{value(2 * i), value(2 * i + 1)};
  }
}

}  // namespace multitetra
