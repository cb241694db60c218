// Own errors of the points of a row, four points at a time: sufficient for all diamonds that are
// active in few bins, which is typical of noise.
//
// Requires values that float represents exactly with all their sums (16-bit integers), so that all
// comparisons below are exact.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/core/framework/diamond_values.hpp"

namespace multitetra {

// The own errors of four neighbouring points in a row. In lanes with void values only `sum` is
// defined; in lanes of equal values only `sum` and the range are.
struct FourOwnErrors {
  using Vector = Lanes<float>::Vector;
  Vector low{};  // The range of the diamond's values.
  Vector high{};
  Vector sum{};    // NaN if any value is void.
  Vector moved{};  // The change of the point's value when it is fused.
  // The largest displacement for any isovalue, by either measure.
  Vector paper{};
  Vector certified{};
  // The isovalues [flip_from, flip_to) for which fusing is a flip.
  Vector flip_from{};
  Vector flip_to{};
  Vector critical{};  // Greater than 0 if the flip is critical for any of these.
};

// The diamonds of a row: the offsets of the corners from points with an even and with an odd index
// in the row; the split edge's ends first, then the ring in cyclic order.
struct RowDiamonds {
  std::size_t corners = 0;
  const std::ptrdiff_t* even = nullptr;
  const std::ptrdiff_t* odd = nullptr;
  std::array<Lanes<float>::Vector, 10> length{};  // By corner; lanes alternate like the points.
};

template <std::size_t kCorners>
inline void compute_four(const float* center, const RowDiamonds& row, FourOwnErrors& errors) {
  using Vector = Lanes<float>::Vector;
  const Vector m = {center[0], center[2], center[4], center[6]};
  std::array<Vector, kCorners> x;
  for (std::size_t i = 0; i < kCorners; ++i) {
    const float* const even = center + row.even[i];
    const float* const odd = center + row.odd[i];
    x[i] = Vector{even[0], odd[2], even[4], odd[6]};
  }
  Vector least = m;
  Vector largest = m;
  Vector sum = m;
  for (const Vector& value : x) {
    least = value < least ? value : least;
    largest = value > largest ? value : largest;
    sum += value;
  }
  errors.low = least;
  errors.high = largest;
  errors.sum = sum;
  const auto is_mixed = least < largest;
  if ((is_mixed[0] | is_mixed[1] | is_mixed[2] | is_mixed[3]) == 0) return;

  const Vector v = (x[0] + x[1]) / 2;
  const Vector low = v < m ? v : m;
  const Vector high = v > m ? v : m;
  const Vector extent = high - low;
  errors.moved = extent;
  Vector from_low{};
  Vector from_high{};
  for (std::size_t i = 0; i < kCorners; ++i) {
    const Vector length = row.length[i];
    const Vector up = length * (extent / larger(extent, x[i] - low));
    const Vector down = length * (extent / larger(extent, high - x[i]));
    from_low = larger(from_low, x[i] > low ? up : Vector{});
    from_high = larger(from_high, x[i] < high ? down : Vector{});
  }
  errors.paper = larger(from_low, from_high);
  errors.certified = from_low + from_high;

  const Vector above = larger(x[0], x[1]);
  const Vector below = x[0] < x[1] ? x[0] : x[1];
  const Vector from = m > above ? above : m;
  const Vector to = m > above ? m : larger(below, m);
  errors.flip_from = from;
  errors.flip_to = to;
  // The ring's signs change twice for each pair of neighbours that descends past the isovalue. The
  // descents cover every value between the ring's least and largest at least once. So they cover
  // the flip's range exactly once if it lies between these and is as long as the descents in it.
  Vector ring_low = x[2];
  Vector ring_high = x[2];
  Vector descents{};
  const auto cut = [&](Vector value) {
    const Vector raised = value > from ? value : from;
    return raised < to ? raised : to;
  };
  const Vector first = cut(x[2]);
  Vector here = first;
  for (std::size_t i = 2; i < kCorners; ++i) {
    ring_low = x[i] < ring_low ? x[i] : ring_low;
    ring_high = x[i] > ring_high ? x[i] : ring_high;
    const Vector next = i + 1 < kCorners ? cut(x[i + 1 < kCorners ? i + 1 : i]) : first;
    descents += larger(here - next, Vector{});
    here = next;
  }
  const Vector beyond = larger(ring_low - from, to - ring_high);
  errors.critical = larger(beyond, descents - (to - from));
}

// Computes the points center, center + 2, ...; reads up to six values after the last diamond.
inline void compute_row(const float* center, std::size_t count, const RowDiamonds& row,
                        std::vector<FourOwnErrors>& errors) {
  errors.resize((count + 3) / 4);
  for (std::size_t i = 0; i < errors.size(); ++i, center += 8) {
    switch (row.corners) {
      case 6:
        compute_four<6>(center, row, errors[i]);
        break;
      case 8:
        compute_four<8>(center, row, errors[i]);
        break;
      default:
        compute_four<10>(center, row, errors[i]);
    }
  }
}

}  // namespace multitetra
