#include "server/core/level_wavefront.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace multitetra {
namespace {

// The union of the blocks that a point's children and its own values need.
struct BlockRange {
  int begin = 256;
  int end = 0;
  void include(int first, int last) {
    begin = std::min(begin, first);
    end = std::max(end, last);
  }
};

void take_larger(CurveBlock* into, const CurveBlock* from, int count) {
  for (int i = 0; i < count; ++i) {
    into[i].paper = larger(into[i].paper, from[i].paper);
    into[i].certified = larger(into[i].certified, from[i].certified);
    into[i].flips = larger(into[i].flips, from[i].flips);
  }
}

}  // namespace

template <typename Real>
LevelWavefront<Real>::LevelWavefront(const Grid& grid, const Vec3& spacing,
                                     const IsovalueBins& bins, const LevelWindow& window)
    : grid_(grid),
      bins_(bins),
      window_(window),
      lengths_(diamond_lengths<Real>(StepLengths(spacing), window.exponent)),
      next_(window.first_step()) {
  assert(window.low.z % 2 == 0);
  const std::int32_t last = grid.side() >> window.exponent;
  const GridPoint high = window.low + window.extent;  // One beyond the window's last point.
  plane_low_ = {std::max(0, window.low.x - 1), std::max(0, window.low.y - 1), 0};
  plane_extent_ = GridPoint{std::min(last, high.x) + 1, std::min(last, high.y) + 1, 0} - plane_low_;
  plane_size_ = std::ptrdiff_t{plane_extent_.x} * plane_extent_.y;
  planes_.resize(static_cast<std::size_t>(8 * plane_size_));
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
      children.add({layer.find(p.x + side, p.y), &layer});
      children.add({layer.find(p.x, p.y + side), &layer});
    }
    return children;
  });
}

template <typename Real>
void LevelWavefront<Real>::fill_odd(std::int32_t z, const FinerCubes& finer) {
  odd_.reset(window_.low, window_.extent);
  make_offsets(z);
  const auto add_above_and_below = [&](GridPoint p, Children& children) {
    for (const CurveLayer& even : even_) children.add({even.find(p.x, p.y), &even});
  };
  const auto add_beside = [&](GridPoint p, bool along_x, bool along_y, Children& children) {
    for (const std::int32_t side : {-1, 1}) {
      if (along_x) children.add({odd_.find(p.x + side, p.y), &odd_});
      if (along_y) children.add({odd_.find(p.x, p.y + side), &odd_});
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
  // A cube of the finer level at z = 2 k' + 1, in its own units, is of its step k'.
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
  for (std::int32_t y = first_y; y < window_.low.y + window_.extent.y; y += 2) {
    for (std::int32_t x = first_x; x < window_.low.x + window_.extent.x; x += 2) {
      fill({x, y, z}, layer, add_children(GridPoint{x, y, z}));
    }
  }
}

template <typename Real>
void LevelWavefront<Real>::load(GridPoint p, DiamondValues<Real>& d) const {
  const std::size_t index = diamond_index(p);
  const Diamond& shape = kDiamonds[index];
  const std::int32_t last = grid_.side() >> window_.exponent;
  const std::ptrdiff_t here =
      (p.x - plane_low_.x) + std::ptrdiff_t{plane_extent_.x} * (p.y - plane_low_.y);
  const float* const centre = plane(p.z) + here;
  const auto& offsets = offsets_[index];
  const auto value = [&](std::size_t i) { return static_cast<Real>(centre[offsets[i]]); };
  if (std::min({p.x, p.y, p.z}) == 0 || std::max({p.x, p.y, p.z}) == last) {
    return load_at_border(p, last, static_cast<Real>(*centre), lengths_, value, d);
  }
  d.centre = static_cast<Real>(*centre);
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
void LevelWavefront<Real>::fill(GridPoint p, CurveLayer& layer, const Children& children) {
  DiamondValues<Real> values;
  load(p, values);
  const ValueRange<Real> range = range_of(values);
  BlockRange needed;
  for (std::size_t i = 0; i < children.count; ++i) {
    const CurveLayer::Curve curve = children.of[i].curve;
    needed.include(curve.first, curve.first + curve.count);
  }
  typename OwnErrorCurve<Real>::Bins active{};
  if (range.is_mixed()) {
    active = {.first = bins_.first_from(static_cast<float>(range.low)),
              .last = bins_.last_below(static_cast<float>(range.high))};
    needed.include(active.first / 4, active.last / 4 + 1);
  }
  if (needed.end <= needed.begin) return;

  CurveLayer::Curve curve = {.offset = 0,
                             .first = static_cast<std::uint16_t>(needed.begin),
                             .count = static_cast<std::uint16_t>(needed.end - needed.begin)};
  CurveBlock* const blocks = layer.append(curve.count, curve.offset);
  for (std::size_t i = 0; i < children.count; ++i) {
    const Child& child = children.of[i];
    take_larger(blocks + (child.curve.first - needed.begin), child.layer->blocks(child.curve),
                child.curve.count);
  }
  if (range.is_mixed()) {
    OwnErrorCurve<Real> own(bins_, values, active, blocks, 4 * needed.begin,
                            static_cast<std::uint8_t>(1 + window_.exponent));
    range.any_void ? own.add_void() : own.add();
  }
  layer.at(p.x, p.y) = curve;
}

template class LevelWavefront<float>;
template class LevelWavefront<double>;

}  // namespace multitetra
