#include "server/core/fine_errors.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "server/core/diamond.hpp"
#include "server/core/own_error.hpp"
#include "server/core/rounding.hpp"

namespace multitetra {
namespace {

// Grid steps beyond the cube in which errors of spacing 1, 2 and 4 are needed.
constexpr std::array<std::int32_t, kSpectrumExponent> kReach = {6, 4, 0};

// The points of one kind in a row along x: which coordinates are odd, and where children lie.
struct RowKind {
  bool exists = false;
  bool odd_x = false;
  PointList<11> diamond;  // The point, its split edge and its link, in units of the spacing.
  PointList<8> children;  // In units of the children's spacing.
};

// By kind and by 2 * (z is odd) + (y is odd), in units of the spacing.
constexpr std::array<std::array<RowKind, 4>, 3> make_row_kinds() {
  std::array<std::array<RowKind, 4>, 3> rows{};
  for (int kind = 0; kind < 3; ++kind) {
    for (int row = 0; row < 4; ++row) {
      const int odd_x = kind + 1 - (row & 1) - (row >> 1);
      if (odd_x != 0 && odd_x != 1) continue;
      RowKind& shape = rows[static_cast<std::size_t>(kind)][static_cast<std::size_t>(row)];
      shape.exists = true;
      shape.odd_x = odd_x == 1;
      const GridPoint unit_point = {4 + odd_x, 4 + (row & 1), 4 + (row >> 1)};
      const Diamond& diamond = diamond_of(unit_point);
      shape.diamond.push_back({});
      for (std::size_t i = 0; i < diamond.corners; ++i) {
        shape.diamond.push_back(diamond.offsets[i]);
      }
      // Twice the units, so that the children of an edge are grid points.
      const DividingPoint point(2 * unit_point);
      const PointList<8> children = point.children(Grid(5));
      for (const GridPoint child : children) {
        const GridPoint offset = child - point.at();
        shape.children.push_back(point.kind() == PointKind::kEdge
                                     ? offset
                                     : GridPoint{offset.x / 2, offset.y / 2, offset.z / 2});
      }
    }
  }
  return rows;
}
constexpr auto kRowKinds = make_row_kinds();

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
      arrays_(arrays) {
  const StepLengths lengths(volume.info.spacing);
  for (std::size_t exponent = 0; exponent < lengths_.size(); ++exponent) {
    for (std::size_t shape = 0; shape < kDiamonds.size(); ++shape) {
      const Diamond& diamond = kDiamonds[shape];
      for (std::size_t i = 0; i < diamond.corners; ++i) {
        lengths_[exponent][shape].set(i, (1 << exponent) * lengths(diamond.offsets[i], 1));
      }
    }
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
    arrays_.above.resize(size / 8 + 2);
    arrays_.below.resize(size / 8 + 2);
  }
  visit_type(volume_.info.type, [this](const auto* type) { load_values(type); });
  for (int exponent = 0; exponent < kSpectrumExponent; ++exponent) compute(exponent);
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
  using Mask = std::int32_t __attribute__((vector_size(16)));
  using Float4 = Lanes<float>::Vector;
  constexpr Mask kLow = {1, 2, 4, 8};
  constexpr Mask kHigh = {16, 32, 64, 128};
  const auto byte = [](Mask m) { return static_cast<std::uint8_t>(m[0] | m[1] | m[2] | m[3]); };
  const Float4 c = all(isovalue_below_);
  for (std::int32_t z = 0; z < kCell; ++z) {
    for (std::int32_t y = 0; y < kCell; ++y) {
      const std::ptrdiff_t at = cell.at + row_ * y + slice_ * z;
      std::array<Float4, 2> v;
      std::memcpy(v.data(), &arrays_.values[static_cast<std::size_t>(at)], sizeof(v));
      const auto bits = static_cast<std::size_t>(at / 8 + 1);
      arrays_.above[bits] = byte(((v[0] > c) & kLow) | ((v[1] > c) & kHigh));
      arrays_.below[bits] = byte(((v[0] <= c) & kLow) | ((v[1] <= c) & kHigh));
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
  const std::int32_t last = volume_.info.grid_exponent;
  // Only where somebody asks, and within the grid.
  const auto begin = [&](std::int32_t low, std::int32_t origin) {
    return std::max({low, origin + kCell - reach, 0});
  };
  const auto end = [&](std::int32_t low, std::int32_t origin) {
    return std::min({low + kCell - 1, origin + kCell + side_ + reach, 1 << last});
  };
  const Range x = {begin(cell.low.x, origin_.x), end(cell.low.x, origin_.x)};
  for (std::int32_t z = begin(cell.low.z, origin_.z); z <= end(cell.low.z, origin_.z); z += step) {
    for (std::int32_t y = begin(cell.low.y, origin_.y); y <= end(cell.low.y, origin_.y);
         y += step) {
      compute_row(cell, x, y, z, exponent, kind);
    }
  }
}

// Bit i: the diamond of the point at (cell.low.x + i, y, z), of spacing 1, has values on both
// sides.
unsigned FineErrors::mixed_diamonds(const PointList<11>& diamond, std::ptrdiff_t row_start) const {
  unsigned above = 0;
  unsigned below = 0;
  const std::ptrdiff_t at = row_start / 8 + 1;
  for (const GridPoint offset : diamond) {
    const auto byte = static_cast<std::size_t>(at + (row_ * offset.y + slice_ * offset.z) / 8);
    const auto window = [&](const std::vector<std::uint8_t>& bits) {
      const unsigned all = bits[byte - 1] | static_cast<unsigned>(bits[byte]) << 8 |
                           static_cast<unsigned>(bits[byte + 1]) << 16;
      return all >> (8 + offset.x);
    };
    above |= window(arrays_.above);
    below |= window(arrays_.below);
  }
  return above & below & 0xFFU;
}

void FineErrors::compute_row(const Cell& cell, Range x_range, std::int32_t y, std::int32_t z,
                             int exponent, PointKind kind) {
  const auto row = static_cast<std::size_t>((y >> exponent & 1) | (z >> exponent & 1) << 1);
  const RowKind& shape = kRowKinds[static_cast<std::size_t>(kind)][row];
  if (!shape.exists) return;
  const std::int32_t step = 1 << exponent;
  // Children of an edge have half the spacing; at spacing 1 there are none.
  const bool has_children = kind != PointKind::kEdge || exponent > 0;
  const std::int32_t child_step = kind == PointKind::kEdge ? step / 2 : step;
  std::array<std::ptrdiff_t, 8> children{};
  std::size_t count = 0;
  if (has_children) {
    for (const GridPoint offset : shape.children) {
      children[count++] = child_step * (offset.x + row_ * offset.y + slice_ * offset.z);
    }
  }
  const std::ptrdiff_t start = index({cell.low.x, y, z});
  unsigned mixed = cell.is_crossed ? 0xFFU : 0U;
  if (exponent == 0 && cell.is_crossed) mixed = mixed_diamonds(shape.diamond, start);
  if (count == 0 && mixed == 0) return;

  std::int32_t x = x_range.first;  // A multiple of the spacing.
  if (((x >> exponent & 1) != 0) != shape.odd_x) x += step;
  for (; x <= x_range.last; x += 2 * step) {
    const std::ptrdiff_t at = start + (x - cell.low.x);
    float below = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const float child = arrays_.errors[static_cast<std::size_t>(at + children[i])];
      below = child > below ? child : below;
    }
    const bool is_active = (mixed >> (x - cell.low.x) & 1U) != 0;
    arrays_.errors[static_cast<std::size_t>(at)] =
        is_active ? with_own_error({x, y, z}, at, exponent, below) : below;
  }
}

float FineErrors::with_own_error(GridPoint p, std::ptrdiff_t at, int exponent, float below) const {
  DiamondValues<double> d;
  load_diamond(p, at, exponent, d);
  const OwnError own = own_error(d, options_.isovalue);
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
  const std::size_t index = diamond_index({p.x >> exponent, p.y >> exponent, p.z >> exponent});
  const Diamond& shape = kDiamonds[index];
  const std::int32_t last = 1 << volume_.info.grid_exponent;
  const auto place = [&](GridPoint offset) {
    return static_cast<std::size_t>(at + (std::ptrdiff_t{1} << exponent) *
                                             (offset.x + row_ * offset.y + slice_ * offset.z));
  };
  d.centre = static_cast<double>(arrays_.values[static_cast<std::size_t>(at)]);
  d.vectors = (shape.corners + Lanes<double>::kWidth - 1) / Lanes<double>::kWidth;
  alignas(16) std::array<double, 12> value;
  value.fill(d.centre);
  const bool is_inside = std::min({p.x, p.y, p.z}) > 0 && std::max({p.x, p.y, p.z}) < last;
  if (is_inside) {
    d.corners = shape.corners;
    d.length = &lengths_[static_cast<std::size_t>(exponent)][index];
    for (std::size_t i = 0; i < shape.corners; ++i) {
      value[i] = static_cast<double>(arrays_.values[place(shape.offsets[i])]);
    }
  } else {
    d.corners = 0;
    d.length_at_border = {};
    d.length = &d.length_at_border;
    for (std::size_t i = 0; i < shape.corners; ++i) {
      const GridPoint corner = p + (1 << exponent) * shape.offsets[i];
      if (std::min({corner.x, corner.y, corner.z}) < 0 ||
          std::max({corner.x, corner.y, corner.z}) > last) {
        continue;
      }
      d.length_at_border.set(d.corners, lengths_[static_cast<std::size_t>(exponent)][index][i]);
      value[d.corners++] = static_cast<double>(arrays_.values[place(shape.offsets[i])]);
    }
  }
  d.ring_is_open = d.corners != shape.corners;
  std::memcpy(&d.value, value.data(), sizeof(value));
}

}  // namespace multitetra
