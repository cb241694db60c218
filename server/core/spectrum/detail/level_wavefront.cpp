#include "server/core/spectrum/detail/level_wavefront.hpp"

#include <algorithm>
#include <cassert>
#include <type_traits>
#include <utility>

namespace multitetra {
namespace {

constexpr std::size_t kBeyondRow = 8;  // The number of values that compute_row reads beyond a row.

// The union of the blocks of a point's children and of its own values.
struct BlockRange {
  int begin = 256;
  int end = 0;
  void include(int first, int last) {
    begin = std::min(begin, first);
    end = std::max(end, last);
  }
};

void take_larger(CurveBlock& into, const CurveBlock& from) {
  into.paper = larger(into.paper, from.paper);
  into.certified = larger(into.certified, from.certified);
  into.flips = larger(into.flips, from.flips);
}

}  // namespace

template <typename Real>
LevelWavefront<Real>::LevelWavefront(const Grid& grid, const Vec3& spacing,
                                     const IsovalueBins& bins, const LevelWindow& window)
    : grid_(grid),
      bins_(bins),
      window_(window),
      lengths_(diamond_lengths<Real>(GridStepLengths(spacing), window.exponent)),
      next_(window.first_step()) {
  assert(window.low.z % 2 == 0);
  const std::int32_t last = grid.side() >> window.exponent;
  const GridPoint high = window.low + window.extent;  // Exclusive.
  plane_low_ = {std::max(0, window.low.x - 1), std::max(0, window.low.y - 1), 0};
  plane_extent_ = GridPoint{std::min(last, high.x) + 1, std::min(last, high.y) + 1, 0} - plane_low_;
  plane_size_ = std::ptrdiff_t{plane_extent_.x} * plane_extent_.y;
  planes_.resize(static_cast<std::size_t>(8 * plane_size_) + kBeyondRow);
  loaded_ = std::max(0, window.low.z - 1) - 1;
  for (CurveLayer& layer : even_) layer.reset(window.low, window.extent);
}

template <typename Real>
void LevelWavefront<Real>::load_plane(const PlaneSource& values) {
  ++loaded_;
  values.read(window_.exponent, {plane_low_.x, plane_low_.y, loaded_}, plane_extent_,
              planes_.data() + (loaded_ & 7) * plane_size_);
}

template <typename Real>
void LevelWavefront<Real>::make_offsets(std::int32_t z) {
  for (std::size_t shape = 0; shape < kDiamonds.size(); ++shape) {
    for (std::size_t i = 0; i < kDiamonds[shape].corners; ++i) {
      const GridPoint offset = kDiamonds[shape].offsets[i];
      offsets_[shape][i] =
          offset.x + std::ptrdiff_t{plane_extent_.x} * offset.y + (plane(z + offset.z) - plane(z));
    }
  }
}

template <typename Real>
void LevelWavefront<Real>::step(const FinerCubes& finer) {
  assert(has_values() && !is_done());
  const std::int32_t k = next_++;
  if (k == window_.first_step()) {
    fill_even(2 * k, even_[1 - lower_], finer);
  }
  lower_ = 1 - lower_;
  fill_even(2 * k + 2, even_[1 - lower_], finer);
  fill_odd(2 * k + 1, finer);
}

template <typename Real>
void LevelWavefront<Real>::copy_cubes(CurveLayer& into) const {
  const GridPoint low = {window_.low.x >> 1, window_.low.y >> 1, 0};
  const GridPoint last = window_.low + window_.extent - GridPoint{1, 1, 1};
  into.reset(low, GridPoint{last.x >> 1, last.y >> 1, 0} - low + GridPoint{1, 1, 0});
  for (std::int32_t y = window_.low.y | 1; y <= last.y; y += 2) {
    for (std::int32_t x = window_.low.x | 1; x <= last.x; x += 2) {
      CurveLayer::Curve curve = odd_.at(x, y);
      if (curve.count == 0) continue;
      const CurveBlock* const from = odd_.blocks(curve);
      std::copy_n(from, curve.count, into.append(curve.count, curve.offset));
      into.at(x >> 1, y >> 1) = curve;
    }
  }
}

template <typename Real>
void LevelWavefront<Real>::fill_even(std::int32_t z, CurveLayer& layer, const FinerCubes& finer) {
  layer.reset(window_.low, window_.extent);
  if (z >= window_.low.z + window_.extent.z) return;
  make_offsets(z);
  const auto edge = [&](GridPoint p) { return finer_cubes(p, finer); };
  fill_points(z, true, false, layer, edge);
  fill_points(z, false, true, layer, edge);
  fill_points(z, true, true, layer, [&](GridPoint p) {
    Children children;
    for (const std::int32_t side : {-1, 1}) {
      children.add({std::as_const(layer).at(p.x + side, p.y), &layer});
      children.add({std::as_const(layer).at(p.x, p.y + side), &layer});
    }
    return children;
  });
}

template <typename Real>
void LevelWavefront<Real>::fill_odd(std::int32_t z, const FinerCubes& finer) {
  odd_.reset(window_.low, window_.extent);
  make_offsets(z);
  const auto add_above_and_below = [&](GridPoint p, Children& children) {
    for (const CurveLayer& even : std::as_const(even_)) children.add({even.at(p.x, p.y), &even});
  };
  const auto add_beside = [&](GridPoint p, bool along_x, bool along_y, Children& children) {
    for (const std::int32_t side : {-1, 1}) {
      if (along_x) children.add({std::as_const(odd_).at(p.x + side, p.y), &odd_});
      if (along_y) children.add({std::as_const(odd_).at(p.x, p.y + side), &odd_});
    }
  };
  fill_points(z, false, false, odd_, [&](GridPoint p) { return finer_cubes(p, finer); });
  for (const bool odd_x : {true, false}) {
    fill_points(z, odd_x, !odd_x, odd_, [&](GridPoint p) {
      Children children;
      add_above_and_below(p, children);
      add_beside(p, odd_x, !odd_x, children);
      return children;
    });
  }
  fill_points(z, true, true, odd_, [&](GridPoint p) {
    Children children;
    add_above_and_below(p, children);
    add_beside(p, true, true, children);
    return children;
  });
}

template <typename Real>
typename LevelWavefront<Real>::Children LevelWavefront<Real>::finer_cubes(
    GridPoint p, const FinerCubes& finer) const {
  Children children;
  // The finer level's cube at z = 2 k' + 1, in its own units, belongs to its step k'.
  for (const std::int32_t k : {p.z - 1, p.z}) {
    const CurveLayer* const cubes = finer.layer(k);
    if (cubes == nullptr) continue;
    for (const std::int32_t y : {p.y - 1, p.y}) {
      for (const std::int32_t x : {p.x - 1, p.x}) children.add({cubes->find(x, y), cubes});
    }
  }
  return children;
}

template <typename Real>
template <typename AddChildren>
void LevelWavefront<Real>::fill_points(std::int32_t z, bool odd_x, bool odd_y, CurveLayer& layer,
                                       const AddChildren& add_children) {
  const std::int32_t first_x = window_.low.x + (((window_.low.x & 1) != 0) == odd_x ? 0 : 1);
  const std::int32_t first_y = window_.low.y + (((window_.low.y & 1) != 0) == odd_y ? 0 : 1);
  const std::int32_t end_x = window_.low.x + window_.extent.x;
  const std::int32_t last = grid_.side() >> window_.exponent;
  for (std::int32_t y = first_y; y < window_.low.y + window_.extent.y; y += 2) {
    const auto count = static_cast<std::size_t>(std::max(0, end_x - first_x + 1) / 2);
    const bool is_computed = compute_errors({first_x, y, z}, count);
    std::size_t i = 0;
    for (std::int32_t x = first_x; x < end_x; x += 2, ++i) {
      const GridPoint p = {x, y, z};
      const bool is_inside = x > 0 && x < last;
      if (is_computed && is_inside && errors_[i / 4].sum[i % 4] == errors_[i / 4].sum[i % 4]) {
        fill(p, layer, add_children(p), errors_[i / 4], i % 4);
      } else {
        fill(p, layer, add_children(p));
      }
    }
  }
}

// Computes `errors_` of a row, except for points on the border at its ends. Returns false if the
// row does not allow it.
template <typename Real>
bool LevelWavefront<Real>::compute_errors(GridPoint first, std::size_t count) {
  if constexpr (std::is_same_v<Real, float>) {
    const std::int32_t last = grid_.side() >> window_.exponent;
    if (count == 0 || std::min(first.y, first.z) == 0 || std::max(first.y, first.z) == last) {
      return false;
    }
    const std::size_t even = diamond_index(first);
    const std::size_t odd = diamond_index(first + GridPoint{2, 0, 0});
    RowDiamonds row{.corners = kDiamonds[even].corners,
                    .even = offsets_[even].data(),
                    .odd = offsets_[odd].data()};
    for (std::size_t i = 0; i < row.corners; ++i) {
      row.length[i] = FourOwnErrors::Vector{lengths_[even][i], lengths_[odd][i], lengths_[even][i],
                                            lengths_[odd][i]};
    }
    compute_row(plane(first.z) + (first.x - plane_low_.x) +
                    std::ptrdiff_t{plane_extent_.x} * (first.y - plane_low_.y),
                count, row, errors_);
    return true;
  }
  return false;
}

template <typename Real>
void LevelWavefront<Real>::load(GridPoint p, DiamondValues<Real>& d) const {
  const std::size_t index = diamond_index(p);
  const Diamond& shape = kDiamonds[index];
  const std::int32_t last = grid_.side() >> window_.exponent;
  const std::ptrdiff_t here =
      (p.x - plane_low_.x) + std::ptrdiff_t{plane_extent_.x} * (p.y - plane_low_.y);
  const float* const center = plane(p.z) + here;
  const auto& offsets = offsets_[index];
  const auto value = [&](std::size_t i) { return static_cast<Real>(center[offsets[i]]); };
  if (std::min({p.x, p.y, p.z}) == 0 || std::max({p.x, p.y, p.z}) == last) {
    return load_at_border(p, last, static_cast<Real>(*center), lengths_, value, d);
  }
  d.center = static_cast<Real>(*center);
  d.corners = shape.corners;
  d.ring_is_open = false;
  d.length = &lengths_[index];
  d.vectors = (shape.corners + Lanes<Real>::kWidth - 1) / Lanes<Real>::kWidth;
  using Vector = typename Lanes<Real>::Vector;
  for (std::size_t i = 0; i < d.vectors; ++i) {
    if constexpr (Lanes<Real>::kWidth == 4) {
      d.value.vectors[i] =
          Vector{value(4 * i), value(4 * i + 1), value(4 * i + 2), value(4 * i + 3)};
    } else {
      d.value.vectors[i] = Vector{value(2 * i), value(2 * i + 1)};
    }
  }
}

template <typename Real>
typename LevelWavefront<Real>::Bins LevelWavefront<Real>::bins_between(Real low, Real high) const {
  return {.first = bins_.first_from(static_cast<float>(low)),
          .last = bins_.last_below(static_cast<float>(high))};
}

template <typename Real>
typename LevelWavefront<Real>::Appended LevelWavefront<Real>::append(GridPoint p, CurveLayer& layer,
                                                                     const Children& children,
                                                                     bool is_mixed,
                                                                     Bins active) const {
  BlockRange needed;
  for (std::size_t i = 0; i < children.count; ++i) {
    const CurveLayer::Curve curve = children.of[i].curve;
    needed.include(curve.first, curve.first + curve.count);
  }
  if (is_mixed) needed.include(active.first / 4, active.last / 4 + 1);
  if (needed.end <= needed.begin) return {};
  CurveLayer::Curve curve = {.offset = 0,
                             .first = static_cast<std::uint16_t>(needed.begin),
                             .count = static_cast<std::uint16_t>(needed.end - needed.begin)};
  CurveBlock* const blocks = layer.append(curve.count, curve.offset);
  if (curve.count == 1) {
    CurveBlock largest;
    for (std::size_t i = 0; i < children.count; ++i) {
      take_larger(largest, *children.of[i].layer->blocks(children.of[i].curve));
    }
    *blocks = largest;
  } else {
    std::fill_n(blocks, curve.count, CurveBlock{});
    for (std::size_t i = 0; i < children.count; ++i) {
      const Child& child = children.of[i];
      const CurveBlock* const from = child.layer->blocks(child.curve);
      CurveBlock* const into = blocks + (child.curve.first - needed.begin);
      for (int block = 0; block < child.curve.count; ++block) take_larger(into[block], from[block]);
    }
  }
  layer.at(p.x, p.y) = curve;
  return {.blocks = blocks, .first_bin = 4 * needed.begin};
}

template <typename Real>
void LevelWavefront<Real>::add_own(const DiamondValues<Real>& values, Bins active, bool any_void,
                                   const Appended& curve) const {
  OwnErrorCurve<Real> own(bins_, values, active, curve.blocks, curve.first_bin,
                          static_cast<std::uint8_t>(1 + window_.exponent));
  any_void ? own.add_void() : own.add();
}

template <typename Real>
void LevelWavefront<Real>::fill(GridPoint p, CurveLayer& layer, const Children& children) const {
  DiamondValues<Real> values;
  load(p, values);
  const ValueRange<Real> range = range_of(values);
  const bool is_mixed = range.is_mixed();
  const Bins active = is_mixed ? bins_between(range.low, range.high) : Bins{};
  const Appended curve = append(p, layer, children, is_mixed, active);
  if (is_mixed) add_own(values, active, range.any_void, curve);
}

// Fills a point without void values from the row's precomputed errors.
template <typename Real>
void LevelWavefront<Real>::fill(GridPoint p, CurveLayer& layer, const Children& children,
                                const FourOwnErrors& errors, std::size_t lane) const {
  const bool is_mixed = errors.low[lane] < errors.high[lane];
  if (!is_mixed && children.count == 0) return;
  const auto between = [&](float low, float high) {
    return bins_between(static_cast<Real>(low), static_cast<Real>(high));
  };
  const Bins active = is_mixed ? between(errors.low[lane], errors.high[lane]) : Bins{};
  const Appended curve = append(p, layer, children, is_mixed, active);
  if (!is_mixed) return;
  if (!OwnErrorCurve<Real>::is_narrow(active)) {
    DiamondValues<Real> values;
    load(p, values);
    return add_own(values, active, false, curve);
  }
  if (!(errors.moved[lane] > 0)) return;
  const bool flips = errors.flip_from[lane] < errors.flip_to[lane];
  const Bins flipped =
      flips ? between(errors.flip_from[lane], errors.flip_to[lane]) : Bins{.first = 0, .last = -1};
  OwnErrorCurve<Real>::add_narrow(active, errors.paper[lane], errors.certified[lane], flipped,
                                  flips && errors.critical[lane] > 0,
                                  static_cast<std::uint8_t>(1 + window_.exponent), curve.blocks,
                                  curve.first_bin);
}

template class LevelWavefront<float>;
template class LevelWavefront<double>;

}  // namespace multitetra
