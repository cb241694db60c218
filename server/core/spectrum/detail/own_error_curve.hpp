// The own error of one dividing point for all isovalues: an upper bound over every bin.
//
// Let m be the point's value, v the mean of its split edge's ends, A and B the lesser and the
// larger of the two, and x the value of a corner at distance L. Then the displacement |t(m) - t(v)|
// L of own_error.hpp is a tent over the isovalue c:
//
//   x > B   rises over [A, B] as L (c - A) / (x - A), falls over [B, x] as
//           L (B - A) (x - c) / ((x - A) (x - B))
//   x < A   mirrored
//   else    rises over [A, x], falls over [x, B], with L at its peak x
//
// So the maximum over a bin is known without a search: for c >= B it is at the bin's lower end, for
// c <= A at its upper end. For A <= c < B the point and its fused value lie on different sides,
// every corner has one of the two crossings, and the certified error is at most
//
//   R + F   with   R = max over x > c of L (c - A) / (x - A)
//                  F = max over x <= c of L (B - c) / (B - x)
//
// with the largest R and the largest F of the bin.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "server/core/framework/diamond_values.hpp"
#include "server/core/spectrum/detail/error_curve.hpp"
#include "server/core/spectrum/isovalue_bins.hpp"

namespace multitetra {

// Adds the own error of a diamond to the errors of its children in `blocks`, whose first bin is
// `first_bin`: the paper's error becomes the maximum of both, the certified error their sum. `flip`
// is 1 + log2 of the point's spacing. Requires blocks for all bins from `first` =
// first_from(range.low) to `last` = last_below(range.high), and range.is_mixed().
template <typename Real>
class OwnErrorCurve {
 public:
  struct Bins {
    int first;
    int last;
  };
  // Returns whether only a few bins contain isovalues for which the diamond is active, as is
  // typical of noise. Such diamonds use their maximal error in all of these bins.
  [[nodiscard]] static bool is_narrow(Bins active) { return active.last - active.first < kNarrow; }

  // Adds the errors of a narrow diamond whose fusion moves something to its active bins, and a
  // flip, possibly critical, to the bins `flipped` among them (none if `flipped.last` is smaller).
  static void add_narrow(Bins active, float paper, float certified, Bins flipped, bool is_critical,
                         std::uint8_t flip, CurveBlock* blocks, int first_bin) {
    using Int4 = std::int32_t __attribute__((vector_size(16)));
    const Float4 moved = Float4{} + paper * kRoundingUp;
    for (int block = active.first / 4; block <= active.last / 4; ++block) {
      CurveBlock& into = blocks[block - first_bin / 4];
      const Int4 bins = Int4{0, 1, 2, 3} + 4 * block;
      const Int4 is_active = (bins >= active.first) & (bins <= active.last);
      into.paper = larger(into.paper, is_active ? moved : Float4{});
      const Float4 sum = (into.certified + certified) * kRoundingUp;
      if (certified > 0) into.certified = is_active ? sum : into.certified;
      const int first = std::max(flipped.first - 4 * block, 0);
      const int last = std::min(flipped.last - 4 * block, 3);
      if (first > last) continue;
      const std::uint32_t lanes = 0xFFFFFFFFU >> 8 * (3 - last + first) << 8 * first;
      const std::uint64_t marks = lanes & 0x01010101U * flip;
      into.flips =
          larger(into.flips, std::bit_cast<Byte8>(marks | (is_critical ? marks << 32 : 0)));
    }
  }

  OwnErrorCurve(const IsovalueBins& bins, const DiamondValues<Real>& diamond, Bins active,
                CurveBlock* blocks, int first_bin, std::uint8_t flip)
      : bins_(bins),
        d_(diamond),
        active_(active),
        blocks_(blocks),
        first_bin_(first_bin),
        flip_(flip) {}

  // Adds a diamond with void corners, whose flip is critical.
  void add_void() {
    for (int bin = active_.first; bin <= active_.last; ++bin) {
      mark(bin, 0);
      mark(bin, 4);
    }
  }

  void add() {
    const Real a = d_.value[0];
    const Real b = d_.value[1];
    const Real m = d_.center;
    const Real v = (a + b) / 2;
    if (v == m) return;  // Fusing moves nothing.
    low_ = std::min(v, m);
    high_ = std::max(v, m);
    is_narrow() ? add_peaks() : add_to_bins();
    if (m > std::max(a, b)) add_flip(std::max(a, b), m);
    if (m < std::min(a, b)) add_flip(m, std::min(a, b));
  }

 private:
  using Vector = typename Lanes<Real>::Vector;
  // Keeps bounds above the exact errors: a few operations with a relative error of 2^-24 each.
  static constexpr float kRoundingUp = 1 + 0x1p-20F;
  static constexpr int kNarrow = 5;  // In bins.

  [[nodiscard]] bool is_narrow() const { return is_narrow(active_); }

  // Adds the peaks of all tents.
  void add_peaks() {
    const Vector low = all(low_);
    const Vector high = all(high_);
    const Vector extent = high - low;
    Vector from_low{};
    Vector from_high{};
    for (std::size_t i = 0; i < d_.vectors; ++i) {
      const Vector x = d_.value.vectors[i];
      const Vector length = d_.length->vectors[i];
      // extent / max(extent, x - A) cuts the tent off at its true peak L if x lies between A and B.
      const Vector up = length * (extent / larger(extent, x - low));
      const Vector down = length * (extent / larger(extent, high - x));
      from_low = larger(from_low, x > low ? up : Vector{});
      from_high = larger(from_high, x < high ? down : Vector{});
    }
    const Real r = largest_of<Real>(from_low);
    const Real f = largest_of<Real>(from_high);
    for (int bin = active_.first; bin <= active_.last; ++bin) {
      add(bin, static_cast<float>(std::max(r, f)), static_cast<float>(r + f));
    }
  }

  void add_to_bins() {
    const Vector low = all(low_);
    const Vector high = all(high_);
    const Vector extent = high - low;
    const Vector none{};
    for (std::size_t i = 0; i < d_.vectors; ++i) {
      const Vector x = d_.value.vectors[i];
      const Vector length = d_.length->vectors[i];
      const Vector up = x - low;
      const Vector down = high - x;
      const Vector below = up > none ? length / (up > none ? up : all(Real{1})) : none;
      const Vector above = down > none ? length / (down > none ? down : all(Real{1})) : none;
      below_[i] = below;
      above_[i] = above;
      falling_[i] = down < none ? below * extent / (down < none ? -down : all(Real{1})) : none;
      rising_[i] = up < none ? above * extent / (up < none ? -up : all(Real{1})) : none;
    }
    for (int bin = active_.first; bin <= active_.last; ++bin) {
      const auto from = static_cast<Real>(bins_.low(bin));
      const auto to = static_cast<Real>(bins_.high(bin));
      Real paper = 0;
      if (from < low_) paper = largest_rising(std::min(to, low_));
      if (to > high_) paper = std::max(paper, largest_falling(std::max(from, high_)));
      Real certified = paper;
      if (from < high_ && to > low_) {
        const Real r = largest_from_low(std::max(from, low_), std::min(to, high_));
        const Real f = largest_from_high(std::max(from, low_), std::min(to, high_));
        paper = std::max(paper, std::max(r, f));
        certified = std::max(certified, r + f);
      }
      add(bin, static_cast<float>(paper), static_cast<float>(certified));
    }
  }

  [[nodiscard]] Real largest_rising(Real isovalue) const {
    const Vector c = all(isovalue);
    Vector largest{};
    for (std::size_t i = 0; i < d_.vectors; ++i) {
      largest = larger(largest, rising_[i] * (c - d_.value.vectors[i]));
    }
    return largest_of<Real>(largest);
  }
  [[nodiscard]] Real largest_falling(Real isovalue) const {
    const Vector c = all(isovalue);
    Vector largest{};
    for (std::size_t i = 0; i < d_.vectors; ++i) {
      largest = larger(largest, falling_[i] * (d_.value.vectors[i] - c));
    }
    return largest_of<Real>(largest);
  }
  // Returns R over the isovalues from c_low to c_high.
  [[nodiscard]] Real largest_from_low(Real c_low, Real c_high) const {
    const Vector reach = all(c_high - low_);
    Vector largest{};
    for (std::size_t i = 0; i < d_.vectors; ++i) {
      const Vector length = d_.length->vectors[i];
      const Vector risen = below_[i] * reach;
      const Vector moved = risen < length ? risen : length;
      largest = larger(largest, d_.value.vectors[i] > all(c_low) ? moved : Vector{});
    }
    return largest_of<Real>(largest);
  }
  // Returns F over the isovalues from c_low to c_high.
  [[nodiscard]] Real largest_from_high(Real c_low, Real c_high) const {
    const Vector reach = all(high_ - c_low);
    Vector largest{};
    for (std::size_t i = 0; i < d_.vectors; ++i) {
      const Vector length = d_.length->vectors[i];
      const Vector risen = above_[i] * reach;
      const Vector moved = risen < length ? risen : length;
      largest = larger(largest, d_.value.vectors[i] < all(c_high) ? moved : Vector{});
    }
    return largest_of<Real>(largest);
  }

  void add(int bin, float paper, float certified) {
    CurveBlock& block = blocks_[(bin - first_bin_) / 4];
    const int lane = (bin - first_bin_) % 4;
    block.paper[lane] = std::max(block.paper[lane], paper * kRoundingUp);
    const float sum = (block.certified[lane] + certified) * kRoundingUp;
    block.certified[lane] = certified > 0 ? sum : block.certified[lane];
  }

  void mark(int bin, int kind) {
    Byte8& flips = blocks_[(bin - first_bin_) / 4].flips;
    const int lane = kind + (bin - first_bin_) % 4;
    flips[lane] = std::max(flips[lane], flip_);
  }
  // Returns the bins of the isovalues in [from, to).
  [[nodiscard]] Bins bins_between(Real from, Real to) const {
    return {.first = bins_.first_from(static_cast<float>(from)),
            .last = bins_.last_below(static_cast<float>(to))};
  }
  // Marks a flip in all these bins; `kind` is 0, or 4 for a critical flip.
  void mark(Bins bins, int kind) {
    for (int bin = bins.first; bin <= bins.last; ++bin) mark(bin, kind);
  }

  // Adds a flip for the isovalues in [from, to). It is critical where the signs on the ring do not
  // change exactly twice; they change only at the ring's own values.
  void add_flip(Real from, Real to) {
    const Bins flipped = bins_between(from, to);
    mark(flipped, 0);
    if (d_.ring_is_open) return mark(flipped, 4);
    for (Real c = from; c < to;) {
      const bool is_critical = !changes_twice(ring_signs(c));
      if (is_critical && is_narrow()) return mark(flipped, 4);
      const Real next = next_ring_value(c, to);
      if (is_critical) mark(bins_between(c, next), 4);
      c = next;
    }
  }

  // Returns a mask whose bit i is set if ring corner i + 2 has a value greater than c.
  [[nodiscard]] unsigned ring_signs(Real c) const {
    unsigned signs = 0;
    for (std::size_t i = 0; i < d_.vectors; ++i) {
      const auto is_positive = d_.value.vectors[i] > all(c);
      for (std::size_t lane = 0; lane < Lanes<Real>::kWidth; ++lane) {
        signs |= static_cast<unsigned>(is_positive[lane] & 1) << (i * Lanes<Real>::kWidth + lane);
      }
    }
    return (signs >> 2) & ((1U << (d_.corners - 2)) - 1);
  }
  [[nodiscard]] bool changes_twice(unsigned signs) const {
    const unsigned turned = signs >> 1 | (signs & 1U) << (d_.corners - 3);
    const unsigned changes = signs ^ turned;  // Always an even number of bits.
    const unsigned but_one = changes & (changes - 1);
    return changes != 0 && (but_one & (but_one - 1)) == 0;
  }
  // Returns the least value on the ring that is greater than c, or `to` if that is less.
  [[nodiscard]] Real next_ring_value(Real c, Real to) const {
    Real next = to;
    for (std::size_t i = 2; i < d_.corners; ++i) {
      const Real x = d_.value[i];
      next = x > c && x < next ? x : next;
    }
    return next;
  }

  const IsovalueBins& bins_;
  const DiamondValues<Real>& d_;
  Bins active_;
  CurveBlock* blocks_;
  int first_bin_;
  std::uint8_t flip_;
  Real low_ = 0;                                       // A
  Real high_ = 0;                                      // B
  std::array<Vector, Lanes<Real>::kVectors> below_;    // L / (x - A) for x > A, else 0
  std::array<Vector, Lanes<Real>::kVectors> above_;    // L / (B - x) for x < B
  std::array<Vector, Lanes<Real>::kVectors> falling_;  // Slope of the tent beyond B, for x > B
  std::array<Vector, Lanes<Real>::kVectors> rising_;   // Slope of the tent up to A, for x < A
};

}  // namespace multitetra
