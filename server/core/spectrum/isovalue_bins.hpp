// The isovalue axis cut into bins, for each of which a prepared dataset stores its errors.
//
// Bin k holds the isovalues from edge k (included) to edge k + 1 (excluded). The edges begin at the
// least value that the field has and end at the largest: for an isovalue outside of them all values
// are on one side, and every error is 0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/request/dataset_info.hpp"

namespace multitetra {

class IsovalueBins {
 public:
  static constexpr int kDefaultCount = 64;
  static constexpr int kMaxCount = 256;

  // Requires finite edges that increase strictly; 2 to kMaxCount + 1 of them, or none when the
  // field has one value only.
  explicit IsovalueBins(std::vector<float> edges);

  // At most `count` bins for a field with the values of `info`. Integers get bins that are a whole
  // number of values wide and begin at an integer, so that a bin of width 1 has no change of sign
  // inside; where there are few values, 2, 4, ... bins share one. Floats get uniform bins, unless a
  // few of these would hold nearly all of `distinct_values` (ascending): then their edges are
  // quantiles of those. (Quantiles of all samples are a trap: in a noisy background every point
  // would span most bins.)
  [[nodiscard]] static IsovalueBins for_values(const DatasetInfo& info,
                                               std::span<const float> distinct_values,
                                               int count = kDefaultCount);

  [[nodiscard]] int count() const {
    return edges_.empty() ? 0 : static_cast<int>(edges_.size()) - 1;
  }
  [[nodiscard]] const std::vector<float>& edges() const { return edges_; }
  [[nodiscard]] float low(int bin) const { return edges_[static_cast<std::size_t>(bin)]; }
  [[nodiscard]] float high(int bin) const { return edges_[static_cast<std::size_t>(bin) + 1]; }

  // The bin of an isovalue; none when no surface has it.
  [[nodiscard]] std::optional<int> bin_of(double isovalue) const;

  // The first bin that isovalues from `value` on can be in: the one that holds it. Requires count()
  // > 0 and a value that is not below all edges.
  [[nodiscard]] int first_from(float value) const {
    const auto cell = static_cast<std::size_t>((double{value} - double{edges_.front()}) * scale_);
    int bin = guide_[cell < guide_.size() ? cell : guide_.size() - 1];
    while (bin > 0 && low(bin) > value) --bin;
    const int last = count() - 1;
    if (bin < last && high(bin) <= value) bin = search(bin, value);
    return bin;
  }
  // The last bin that isovalues below `value` can be in. Requires a value above the least edge.
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
  double scale_ = 0;                 // Cells of the guide per unit of value.
  std::vector<std::uint8_t> guide_;  // Per uniform cell of values: a bin near its lower end.
};

}  // namespace multitetra
