#include "server/core/fine_errors.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>

#include "server/core/diamond.hpp"
#include "server/core/mixed_diamonds.hpp"
#include "server/core/own_error.hpp"
#include "server/core/rounding.hpp"

namespace multitetra {
namespace {

// Grid steps beyond the cube in which errors of spacing 1, 2 and 4 are needed.
constexpr std::array<std::int32_t, kSpectrumExponent> kReach = {6, 4, 0};

using Float4 = Lanes<float>::Vector;
using Mask = std::int32_t __attribute__((vector_size(16)));
constexpr Mask kLowBits = {1, 2, 4, 8};
constexpr Mask kHighBits = {16, 32, 64, 128};
using Mask8 = std::array<Mask, 2>;

// All ones where the bit is set.
Mask8 mask_of(unsigned bits) {
  const auto lanes = Mask{} + static_cast<std::int32_t>(bits);
  return {(lanes & kLowBits) != 0, (lanes & kHighBits) != 0};
}

// The bits of the points at low, low + 1, ..., low + 7 that lie from `first` to `last`.
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
      cells_in_data_(cell_extent(volume.info)),
      outside_(outside_value(volume.info)),
      isovalue_below_(rounded_down(options.isovalue)),
      settled_above_(rounded_down(options.largest_threshold)),
      arrays_(arrays) {
  const StepLengths lengths(volume.info.spacing);
  for (int exponent = 0; exponent < kSpectrumExponent; ++exponent) {
    lengths_[static_cast<std::size_t>(exponent)] = diamond_lengths<double>(lengths, exponent);
  }
}

void FineErrors::load(const OctreeCube& cube,
                      const std::function<bool(const OctreeCube&)>& is_wanted) {
  assert(cube.exponent >= kSpectrumExponent && cube.exponent <= kMaxExponent);
  side_ = cube.side();
  origin_ = low_of(cube) - GridPoint{kCell, kCell, kCell};
  row_ = side_ + 2 * kCell;
  slice_ = row_ * row_;
  find_cells(is_wanted);
  if (support_.empty()) return;
  const auto size = static_cast<std::size_t>(slice_ * row_);
  if (arrays_.values.size() < size) {
    arrays_.values.resize(size);
    arrays_.errors.resize(size);
  }
  unused_bytes_ = (4 * row_ + 4 * slice_) / 8 + 1;
  const std::size_t bytes = size / 8 + 2 * static_cast<std::size_t>(unused_bytes_);
  if (arrays_.above.size() < bytes) {
    arrays_.above.resize(bytes);
    arrays_.below.resize(bytes);
    arrays_.mixed.resize(bytes);
  }
  visit_type(volume_.info.type, [this](const auto* type) { load_values(type); });
  for (const Cell& cell : support_) {
    if (cell.is_crossed) find_mixed_diamonds(cell);
  }
  make_offsets();
  for (int exponent = 0; exponent < kSpectrumExponent; ++exponent) compute(exponent);
}

// Where corners and children lie in the arrays, whose strides depend on the cube's size.
void FineErrors::make_offsets() {
  const auto offset_of = [this](GridPoint p) { return p.x + row_ * p.y + slice_ * p.z; };
  for (std::size_t shape = 0; shape < kDiamonds.size(); ++shape) {
    for (std::size_t i = 0; i < kDiamonds[shape].corners; ++i) {
      offsets_[shape][i] = offset_of(kDiamonds[shape].offsets[i]);
    }
  }
}

// ---- cells

// Whether the closed cell has values on both sides of the isovalue.
bool FineErrors::may_cross(GridPoint cell) const {
  if (!cells_in_data_.contains(cell)) return false;
  return visit_type(volume_.info.type, [&]<typename Sample>(const Sample*) {
    std::array<Sample, 2> range;
    std::memcpy(range.data(), volume_.ranges.data() + sizeof(range) * cells_in_data_.index(cell),
                sizeof(range));
    if (range[0] > range[1]) return false;  // All void, or nothing but what lies outside.
    auto low = static_cast<float>(range[0]);
    auto high = static_cast<float>(range[1]);
    const GridPoint first = first_sample(volume_.info);
    const GridPoint last = last_sample(volume_.info);
    for (int axis = 0; axis < 3; ++axis) {
      if (kCell * cell[axis] < first[axis] || kCell * (cell[axis] + 1) > last[axis]) {
        low = outside_ < low ? outside_ : low;  // False when it is void.
        high = outside_ > high ? outside_ : high;
      }
    }
    return high > isovalue_below_ && !(low > isovalue_below_);
  });
}

void FineErrors::find_cells(const std::function<bool(const OctreeCube&)>& is_wanted) {
  const std::int32_t side = side_ / kCell;  // Of the cube, in cells; the array has side + 2.
  cells_ = side + 2;
  const auto index = [this](std::int32_t i, std::int32_t j, std::int32_t k) {
    return static_cast<std::size_t>(i + cells_ * (j + cells_ * k));
  };
  const auto size = static_cast<std::size_t>(cells_ * cells_ * cells_);
  const GridPoint first = {origin_.x / kCell, origin_.y / kCell, origin_.z / kCell};
  wanted_.assign(size, false);
  std::vector<std::uint8_t> is_support(size);
  std::vector<std::uint8_t> is_crossed(size);
  bool any = false;
  for (std::int32_t k = 1; k <= side; ++k) {
    for (std::int32_t j = 1; j <= side; ++j) {
      for (std::int32_t i = 1; i <= side; ++i) {
        if (!is_wanted({kSpectrumExponent, first.x + i, first.y + j, first.z + k})) continue;
        any = true;
        wanted_[index(i, j, k)] = true;
        for (int n = 0; n < 27; ++n) {
          is_support[index(i + n % 3 - 1, j + n / 3 % 3 - 1, k + n / 9 - 1)] = 1;
        }
      }
    }
  }
  support_.clear();
  if (!any) return;
  // The range of a cell counts for its own points and for those of the cells above it, whose
  // diamonds reach into it.
  const auto last = cells_ - 1;
  for (std::int32_t k = -1; k <= last; ++k) {
    for (std::int32_t j = -1; j <= last; ++j) {
      for (std::int32_t i = -1; i <= last; ++i) {
        if (!may_cross(first + GridPoint{i, j, k})) continue;
        for (int n = 0; n < 8; ++n) {
          const std::int32_t x = i + (n & 1);
          const std::int32_t y = j + (n >> 1 & 1);
          const std::int32_t z = k + (n >> 2);
          if (std::min({x, y, z}) >= 0 && std::max({x, y, z}) <= last)
            is_crossed[index(x, y, z)] = 1;
        }
      }
    }
  }
  for (std::int32_t k = 0; k <= last; ++k) {
    for (std::int32_t j = 0; j <= last; ++j) {
      for (std::int32_t i = 0; i <= last; ++i) {
        if (is_support[index(i, j, k)] == 0) continue;
        Cell cell{.low = kCell * (first + GridPoint{i, j, k}),
                  .at = 0,
                  .is_crossed = false,
                  .is_near = false};
        cell.at = this->index(cell.low);
        cell.is_crossed = is_crossed[index(i, j, k)] != 0;
        for (int n = 0; n < 27; ++n) {
          const std::int32_t x = std::clamp(i + n % 3 - 1, 0, last);
          const std::int32_t y = std::clamp(j + n / 3 % 3 - 1, 0, last);
          const std::int32_t z = std::clamp(k + n / 9 - 1, 0, last);
          cell.is_near = cell.is_near || is_crossed[index(x, y, z)] != 0;
        }
        support_.push_back(cell);
      }
    }
  }
}

bool FineErrors::is_wanted(const OctreeCube& cell) const {
  const auto along = [this](std::int32_t position, std::int32_t origin) {
    return position - origin / kCell;
  };
  return wanted_[static_cast<std::size_t>(
      along(cell.x, origin_.x) +
      cells_ * (along(cell.y, origin_.y) + cells_ * along(cell.z, origin_.z)))];
}

// ---- values

template <typename Sample>
void FineErrors::load_values(const Sample*) {
  for (const Cell& cell : support_) {
    load_cell<Sample>(cell);
    if (cell.is_near) load_signs(cell);
    for (std::int32_t z = 0; z < kCell; ++z) {
      for (std::int32_t y = 0; y < kCell; ++y) {
        std::fill_n(arrays_.errors.begin() + cell.at + row_ * y + slice_ * z, kCell, 0.0F);
      }
    }
  }
}

template <typename Sample>
void FineErrors::load_cell(const Cell& cell) {
  const DatasetInfo& info = volume_.info;
  const GridPoint margin = first_sample(info);
  const GridPoint begin = cell.low - margin;  // Sample indices; the cell may reach over the data.
  GridPoint low;
  GridPoint high;  // Exclusive.
  const auto clip = [&](std::int32_t from, std::int32_t dims, std::int32_t& a, std::int32_t& b) {
    a = std::clamp(from, 0, dims);
    b = std::clamp(from + kCell, 0, dims);
  };
  clip(begin.x, info.dims[0], low.x, high.x);
  clip(begin.y, info.dims[1], low.y, high.y);
  clip(begin.z, info.dims[2], low.z, high.z);
  const auto into = [&](std::int32_t x, std::int32_t y, std::int32_t z) {
    return arrays_.values.begin() + cell.at + (x - begin.x) + row_ * (y - begin.y) +
           slice_ * (z - begin.z);
  };
  const GridPoint size = high - low;
  if (size.x < kCell || size.y < kCell || size.z < kCell) {
    for (std::int32_t z = 0; z < kCell; ++z) {
      for (std::int32_t y = 0; y < kCell; ++y) {
        std::fill_n(into(begin.x, begin.y + y, begin.z + z), kCell, outside_);
      }
    }
    if (size.x <= 0 || size.y <= 0 || size.z <= 0) return;
  }
  constexpr std::int32_t kSide = BrickLayout::kSampleSide;
  const BrickLayout layout(info.dims);
  for (std::int32_t bz = low.z / kSide; bz * kSide < high.z; ++bz) {
    for (std::int32_t by = low.y / kSide; by * kSide < high.y; ++by) {
      for (std::int32_t bx = low.x / kSide; bx * kSide < high.x; ++bx) {
        const auto* const brick = reinterpret_cast<const Sample*>(
            volume_.samples->brick(layout.index({bx, by, bz})).data());
        const GridCounts extent = layout.extent({bx, by, bz});
        const std::int32_t x0 = std::max(low.x, kSide * bx);
        const std::int32_t x1 = std::min(high.x, kSide * bx + kSide);
        for (std::int32_t z = std::max(low.z, kSide * bz); z < std::min(high.z, kSide * bz + kSide);
             ++z) {
          for (std::int32_t y = std::max(low.y, kSide * by);
               y < std::min(high.y, kSide * by + kSide); ++y) {
            const Sample* const from =
                brick + (x0 - kSide * bx) +
                std::ptrdiff_t{extent[0]} *
                    ((y - kSide * by) + std::ptrdiff_t{extent[1]} * (z - kSide * bz));
            std::transform(from, from + (x1 - x0), into(x0, y, z),
                           [](Sample sample) { return static_cast<float>(sample); });
          }
        }
      }
    }
  }
}

// Eight bits a row of the cell.
void FineErrors::load_signs(const Cell& cell) {
  const auto byte = [](Mask m) { return static_cast<std::uint8_t>(m[0] | m[1] | m[2] | m[3]); };
  const Float4 c = all(isovalue_below_);
  for (std::int32_t z = 0; z < kCell; ++z) {
    for (std::int32_t y = 0; y < kCell; ++y) {
      const std::ptrdiff_t at = cell.at + row_ * y + slice_ * z;
      std::array<Float4, 2> v;
      std::memcpy(v.data(), &arrays_.values[static_cast<std::size_t>(at)], sizeof(v));
      const std::size_t bits = byte_of(at);
      arrays_.mixed[bits] = 0;
      arrays_.above[bits] = byte(((v[0] > c) & kLowBits) | ((v[1] > c) & kHighBits));
      arrays_.below[bits] = byte(((v[0] <= c) & kLowBits) | ((v[1] <= c) & kHighBits));
    }
  }
}

// ---- errors

void FineErrors::compute(int exponent) {
  for (const PointKind kind : {PointKind::kEdge, PointKind::kFace, PointKind::kCube}) {
    for (const Cell& cell : support_) {
      if (cell.is_near) compute_kind(cell, exponent, kind);
    }
  }
}

void FineErrors::compute_kind(const Cell& cell, int exponent, PointKind kind) {
  const std::int32_t step = 1 << exponent;
  const std::int32_t reach = kReach[static_cast<std::size_t>(exponent)];
  const std::int32_t last = 1 << volume_.info.grid_exponent;
  // Only where somebody asks, and within the grid.
  const auto begin = [&](std::int32_t low, std::int32_t origin) {
    return std::max({low, origin + kCell - reach, 0});
  };
  const auto end = [&](std::int32_t low, std::int32_t origin) {
    return std::min({low + kCell - 1, origin + kCell + side_ + reach, last});
  };
  const unsigned x_bits =
      bits_between(cell.low.x, begin(cell.low.x, origin_.x), end(cell.low.x, origin_.x));
  const std::int32_t end_y = end(cell.low.y, origin_.y);
  const std::int32_t end_z = end(cell.low.z, origin_.z);
  for (std::int32_t z = begin(cell.low.z, origin_.z); z <= end_z; z += step) {
    for (std::int32_t y = begin(cell.low.y, origin_.y); y <= end_y; y += step) {
      const RowKind& shape = row_kind(kind, y >> exponent, z >> exponent);
      if (!shape.exists) continue;
      const unsigned bits = x_bits & kPositions[static_cast<std::size_t>(exponent)][shape.odd_x];
      compute_row({cell.low.x, y, z}, bits, exponent, shape);
    }
  }
}

// All levels and kinds of the cell at once: their points are different ones, so their bits are too.
void FineErrors::find_mixed_diamonds(const Cell& cell) {
  const auto bits_of = [](const std::uint8_t* bytes) {
    return bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8 |
           static_cast<std::uint32_t>(bytes[2]) << 16;
  };
  SignRows rows;
  for (std::int32_t z = SignRows::kFirst; z < SignRows::kEnd; ++z) {
    for (std::int32_t y = SignRows::kFirst; y < SignRows::kEnd; ++y) {
      const std::size_t byte = byte_of(cell.at + row_ * y + slice_ * z) - 1;
      rows.set(y, z, bits_of(&arrays_.above[byte]), bits_of(&arrays_.below[byte]));
    }
  }
  const std::array<std::uint8_t, 64> mixed = mixed_diamonds(rows);
  for (std::int32_t z = 0; z < kCell; ++z) {
    for (std::int32_t y = 0; y < kCell; ++y) {
      arrays_.mixed[byte_of(cell.at + row_ * y + slice_ * z)] =
          mixed[static_cast<std::size_t>(y + kCell * z)];
    }
  }
}

// The points of one kind among the eight from `first` on: those with a bit in `bits`.
void FineErrors::compute_row(GridPoint first, unsigned bits, int exponent, const RowKind& shape) {
  const std::ptrdiff_t at = index(first);
  unsigned mixed = arrays_.mixed[byte_of(at)] & bits;
  float* const errors = arrays_.errors.data() + at;
  std::array<Float4, 2> below{};
  // Children of an edge have half the spacing; at spacing 1 there are none.
  if (!shape.is_edge || exponent > 0) {
    const int child_exponent = shape.is_edge ? exponent - 1 : exponent;
    for (const GridPoint offset : shape.children) {
      const std::ptrdiff_t child = offset.x + row_ * offset.y + slice_ * offset.z;
      std::array<Float4, 2> of;
      std::memcpy(of.data(), errors + (child << child_exponent), sizeof(of));
      below[0] = larger(below[0], of[0]);
      below[1] = larger(below[1], of[1]);
    }
    std::array<Float4, 2> made;
    std::memcpy(made.data(), errors, sizeof(made));
    const Mask8 chosen = mask_of(bits);
    made[0] = chosen[0] ? below[0] : made[0];
    made[1] = chosen[1] ? below[1] : made[1];
    std::memcpy(errors, made.data(), sizeof(made));
  }
  for (; mixed != 0; mixed &= mixed - 1) {
    const auto i = static_cast<std::int32_t>(std::countr_zero(mixed));
    const float of_children = below[static_cast<std::size_t>(i / 4)][i % 4];
    if (of_children > settled_above_) continue;
    errors[i] = with_own_error(first + GridPoint{i, 0, 0}, at + i, exponent, of_children);
  }
}

float FineErrors::with_own_error(GridPoint p, std::ptrdiff_t at, int exponent, float below) const {
  DiamondValues<double> d;
  load_diamond(p, at, exponent, d);
  const OwnError own = own_error_of_mixed(d, options_.isovalue);
  const bool is_forbidden = options_.rule == TopologyRule::kPaper ? own.flip : own.critical;
  if (is_forbidden && (1 << exponent) > options_.topology_tolerance) {
    return std::numeric_limits<float>::infinity();
  }
  return options_.measure == ErrorMeasure::kPaper
             ? std::max(below, rounded_up(own.displacement))
             : rounded_up(own.certified + static_cast<double>(below));
}

void FineErrors::load_diamond(GridPoint p, std::ptrdiff_t at, int exponent,
                              DiamondValues<double>& d) const {
  const GridPoint unit_point = {p.x >> exponent, p.y >> exponent, p.z >> exponent};
  const std::int32_t last = 1 << (volume_.info.grid_exponent - exponent);
  const std::size_t index = diamond_index(unit_point);
  const auto& lengths = lengths_[static_cast<std::size_t>(exponent)];
  const float* const centre = arrays_.values.data() + at;
  const auto value = [&](std::size_t i) {
    return static_cast<double>(centre[offsets_[index][i] << exponent]);
  };
  if (std::min({p.x, p.y, p.z}) == 0 ||
      std::max({unit_point.x, unit_point.y, unit_point.z}) == last) {
    return load_at_border(unit_point, last, static_cast<double>(*centre), lengths, value, d);
  }
  d.centre = static_cast<double>(*centre);
  d.corners = kDiamonds[index].corners;
  d.vectors = d.corners / Lanes<double>::kWidth;  // The number of corners is even.
  d.ring_is_open = false;
  d.length = &lengths[index];
  for (std::size_t i = 0; i < d.vectors; ++i) {
    d.value.vectors[i] = Lanes<double>::Vector{value(2 * i), value(2 * i + 1)};
  }
}

}  // namespace multitetra
