#include "server/core/spectrum/isovalue_bins.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <utility>

namespace multitetra {
namespace {

constexpr std::size_t kGuideCells = 4096;
// The least width of a bin of integers; exact in float for 16-bit values.
constexpr double kMinWidth = 0x1p-6;

// Returns bins a whole number of values wide or, with more bins than values, a half, a quarter, ...
std::vector<float> integer_edges(float low, float high, int count) {
  double width = std::ceil((double{high} - double{low}) / count);
  while (2 * (double{high} - double{low}) <= count * width && width > kMinWidth) width /= 2;
  std::vector<float> edges;
  for (double edge = low; edge < double{high}; edge += width) {
    edges.push_back(static_cast<float>(edge));
  }
  edges.push_back(high);
  return edges;
}

void push_increasing(std::vector<float>& edges, float edge) {
  if (edges.empty() || edge > edges.back()) edges.push_back(edge);
}

std::vector<float> uniform_edges(float low, float high, int count) {
  std::vector<float> edges;
  for (int i = 0; i < count; ++i) {
    push_increasing(edges, static_cast<float>(low + (double{high} - double{low}) * i / count));
  }
  push_increasing(edges, high);
  return edges;
}

std::vector<float> quantile_edges(std::span<const float> values, float low, float high, int count) {
  std::vector<float> edges = {low};
  for (int i = 1; i < count; ++i) {
    const std::size_t at =
        values.size() * static_cast<std::size_t>(i) / static_cast<std::size_t>(count);
    if (values[at] < high) push_increasing(edges, values[at]);
  }
  push_increasing(edges, high);
  return edges;
}

// Returns whether a sixteenth of the uniform cells contains more than three quarters of the values.
bool is_skewed(std::span<const float> values, float low, float high) {
  constexpr std::size_t kCells = 256;
  std::array<std::size_t, kCells> counts{};
  const double scale = kCells / (double{high} - double{low});
  for (const float value : values) {
    const auto cell = static_cast<std::size_t>((double{value} - double{low}) * scale);
    ++counts[std::min(cell, kCells - 1)];
  }
  std::sort(counts.begin(), counts.end(), std::greater<>());
  std::size_t max_count = 0;
  for (std::size_t i = 0; i < kCells / 16; ++i) max_count += counts[i];
  return 4 * max_count > 3 * values.size();
}

}  // namespace

IsovalueBins::IsovalueBins(std::vector<float> edges) : edges_(std::move(edges)) {
  assert(edges_.size() != 1 && edges_.size() <= kMaxCount + 1);
  assert(std::is_sorted(edges_.begin(), edges_.end(), std::less_equal<>()));
  if (edges_.empty()) return;
  const double extent = double{edges_.back()} - double{edges_.front()};
  scale_ = kGuideCells / extent;
  guide_.resize(kGuideCells);
  for (std::size_t cell = 0; cell < kGuideCells; ++cell) {
    const auto value =
        static_cast<float>(edges_.front() + extent * static_cast<double>(cell) / kGuideCells);
    guide_[cell] = static_cast<std::uint8_t>(search(0, value));
  }
}

IsovalueBins IsovalueBins::for_values(const DatasetInfo& info,
                                      std::span<const float> distinct_values, int count) {
  assert(count >= 1 && count <= kMaxCount);
  const auto outside = static_cast<float>(info.outside.value_or(info.min));
  const float low = std::min(static_cast<float>(info.min), outside);
  const float high = std::max(static_cast<float>(info.max), outside);
  if (low == high) return IsovalueBins({});
  if (info.type != SampleType::kF32 && low == std::floor(low)) {
    return IsovalueBins(integer_edges(low, high, count));
  }
  if (!distinct_values.empty() && is_skewed(distinct_values, low, high)) {
    return IsovalueBins(quantile_edges(distinct_values, low, high, count));
  }
  return IsovalueBins(uniform_edges(low, high, count));
}

std::optional<int> IsovalueBins::bin_of(double isovalue) const {
  if (edges_.empty() || !(isovalue >= double{edges_.front()} && isovalue < double{edges_.back()})) {
    return std::nullopt;
  }
  const auto above = std::upper_bound(edges_.begin(), edges_.end(), isovalue,
                                      [](double c, float edge) { return c < double{edge}; });
  return static_cast<int>(above - edges_.begin()) - 1;
}

int IsovalueBins::search(int from, float value) const {
  const auto above = std::upper_bound(edges_.begin() + from, edges_.end() - 1, value);
  return std::max(0, static_cast<int>(above - edges_.begin()) - 1);
}

}  // namespace multitetra
