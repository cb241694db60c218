// Bins of the isovalue axis: a prepared dataset stores one set of errors per bin.
//
// Bin k contains the isovalues from edge k (included) to edge k + 1 (excluded). The edges range
// from the field's least value to its largest: beyond them, all values are on one side and all
// errors 0.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/dataset/dataset_info.hpp"

namespace multitetra {

class IsovalueBins {
 public:
  static constexpr int kDefaultCount = 64;
  static constexpr int kMaxCount = 256;

  // Requires 2 to kMaxCount + 1 finite, strictly increasing edges, or none for a constant field.
  explicit IsovalueBins(std::vector<float> edges);

  // Returns at most `count` bins for a field with the values of `info`. Bins of integers are a
  // whole number of values wide and begin at an integer, so that no sign changes inside a bin of
  // width 1; with few values, 2, 4, ... bins share one. Bins of floats are uniform, unless a few of
  // them would contain nearly all of `distinct_values` (ascending): then their edges are quantiles
  // of these. (Quantiles of all samples fail: in noise, every point would span most bins.)
  [[nodiscard]] static IsovalueBins for_values(const DatasetInfo& info,
                                               std::span<const float> distinct_values,
                                               int count = kDefaultCount);

  [[nodiscard]] int count() const {
    return edges_.empty() ? 0 : static_cast<int>(edges_.size()) - 1;
  }
  [[nodiscard]] const std::vector<float>& edges() const { return edges_; }
  [[nodiscard]] float low(int bin) const { return edges_[static_cast<std::size_t>(bin)]; }
  [[nodiscard]] float high(int bin) const { return edges_[static_cast<std::size_t>(bin) + 1]; }

  // Returns the bin of an isovalue, or none if it has no surface.
  [[nodiscard]] std::optional<int> bin_of(double isovalue) const;

  // Returns the bin that contains `value`, or the nearest one: the edges of a damaged file may not
  // fit its samples. Requires count() > 0.
  [[nodiscard]] int first_from(float value) const {
    const double cell = (double{value} - double{edges_.front()}) * scale_;
    const auto last_cell = static_cast<double>(guide_.size() - 1);
    int bin = guide_[static_cast<std::size_t>(std::max(0.0, std::min(cell, last_cell)))];
    while (bin > 0 && low(bin) > value) --bin;
    const int last = count() - 1;
    if (bin < last && high(bin) <= value) bin = search(bin, value);
    return bin;
  }
  // Returns the last bin with isovalues < value. Requires a value above the least edge.
  [[nodiscard]] int last_below(float value) const {
    const int bin = first_from(value);
    return bin > 0 && low(bin) == value ? bin - 1 : bin;
  }

  friend bool operator==(const IsovalueBins& a, const IsovalueBins& b) {
    return a.edges_ == b.edges_;
  }

 private:
  [[nodiscard]] int search(int from, float value) const;

  std::vector<float> edges_;
  double scale_ = 0;                 // Guide cells per unit of value.
  std::vector<std::uint8_t> guide_;  // A bin near the lower end of each uniform cell of values.
};

}  // namespace multitetra
