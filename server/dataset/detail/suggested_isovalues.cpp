#include "server/dataset/detail/suggested_isovalues.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "server/dataset/detail/statistics.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kMaxClasses = 4;

// Prefix sums over the bins: the sums over any run of bins take two look-ups.
class RunningSums {
 public:
  explicit RunningSums(const std::vector<std::uint64_t>& counts)
      : weight_(counts.size() + 1), moment_(counts.size() + 1) {
    for (std::size_t bin = 0; bin < counts.size(); ++bin) {
      const auto count = static_cast<double>(counts[bin]);
      weight_[bin + 1] = weight_[bin] + count;
      moment_[bin + 1] = moment_[bin] + count * static_cast<double>(bin);
    }
  }

  // Returns weight * mean^2 of the bins begin to end - 1. The partition that maximizes its sum over
  // all classes maximizes the variance between them.
  [[nodiscard]] double separation(std::size_t begin, std::size_t end) const {
    const double weight = weight_[end] - weight_[begin];
    const double moment = moment_[end] - moment_[begin];
    return weight > 0 ? moment * moment / weight : 0;
  }
  [[nodiscard]] bool empty(std::size_t begin, std::size_t end) const {
    return weight_[end] == weight_[begin];
  }

 private:
  std::vector<double> weight_;
  std::vector<double> moment_;
};

// Returns the bins at which the second and later classes begin in the best partition into
// `classes`. A threshold within a run of empty bins is moved to their middle.
std::vector<std::size_t> best_partition(const RunningSums& sums, std::size_t bins,
                                        std::size_t classes) {
  // best[end] is the largest separation of the first `end` bins into the classes so far.
  std::vector<double> best(bins + 1);
  for (std::size_t end = 0; end <= bins; ++end) best[end] = sums.separation(0, end);
  std::vector<std::vector<std::size_t>> last_begin(classes, std::vector<std::size_t>(bins + 1));
  for (std::size_t added = 1; added < classes; ++added) {
    std::vector<double> next(bins + 1, -1);
    for (std::size_t end = added + 1; end <= bins; ++end) {
      for (std::size_t begin = added; begin < end; ++begin) {
        const double separation = best[begin] + sums.separation(begin, end);
        if (separation <= next[end]) continue;
        next[end] = separation;
        last_begin[added][end] = begin;
      }
    }
    best = std::move(next);
  }
  std::vector<std::size_t> begins(classes - 1);
  std::size_t end = bins;
  for (std::size_t added = classes - 1; added >= 1; --added) {
    end = last_begin[added][end];
    begins[added - 1] = end;
  }
  for (std::size_t& begin : begins) {
    std::size_t last = begin;
    while (last < bins && sums.empty(begin, last + 1)) ++last;
    begin += (last - begin) / 2;
  }
  return begins;
}

// Smooths the counts, so that noise and single bins do not count as peaks.
std::vector<double> smoothed(const std::vector<std::uint64_t>& counts) {
  const std::size_t reach = std::max<std::size_t>(1, counts.size() / 100);
  std::vector<double> smooth(counts.size());
  for (std::size_t bin = 0; bin < counts.size(); ++bin) {
    const std::size_t begin = bin - std::min(bin, reach);
    const std::size_t end = std::min(counts.size(), bin + reach + 1);
    double sum = 0;
    for (std::size_t i = begin; i < end; ++i) sum += static_cast<double>(counts[i]);
    smooth[bin] = sum / static_cast<double>(end - begin);
  }
  return smooth;
}

// Returns whether the histogram has a peak between two thresholds; else their surfaces look alike.
bool has_hill_between(const std::vector<double>& smooth, std::size_t a, std::size_t b) {
  constexpr double kHill = 1.25;
  const auto [low, high] = std::minmax(a, b);
  const double hill = *std::max_element(smooth.begin() + static_cast<std::ptrdiff_t>(low),
                                        smooth.begin() + static_cast<std::ptrdiff_t>(high));
  const auto foot = [&](std::size_t bin) { return smooth[std::min(bin, smooth.size() - 1)]; };
  return hill > kHill * std::max(foot(low), foot(high));
}

// Moves thresholds whose surfaces differ from all earlier ones to the front; is stable otherwise.
std::vector<std::size_t> most_informative_first(const std::vector<std::size_t>& bins,
                                                const std::vector<std::uint64_t>& counts) {
  const std::vector<double> smooth = smoothed(counts);
  std::vector<std::size_t> first;
  std::vector<std::size_t> rest;
  for (const std::size_t bin : bins) {
    const bool is_new = std::all_of(first.begin(), first.end(), [&](std::size_t other) {
      return has_hill_between(smooth, bin, other);
    });
    (is_new ? first : rest).push_back(bin);
  }
  first.insert(first.end(), rest.begin(), rest.end());
  return first;
}

}  // namespace

std::vector<double> suggested_isovalues(const Histogram& histogram) {
  const auto& counts = histogram.counts;
  const auto occupied = static_cast<std::size_t>(
      std::count_if(counts.begin(), counts.end(), [](std::uint64_t count) { return count > 0; }));
  const RunningSums sums(counts);
  std::vector<std::size_t> chosen;
  // A threshold closer than this to an earlier one is redundant.
  const std::size_t apart = std::max<std::size_t>(1, counts.size() / 25);
  for (std::size_t classes = 2; classes <= std::min(kMaxClasses, occupied); ++classes) {
    for (const std::size_t bin : best_partition(sums, counts.size(), classes)) {
      const bool is_new = std::none_of(chosen.begin(), chosen.end(), [&](std::size_t other) {
        return std::max(bin, other) - std::min(bin, other) < apart;
      });
      if (is_new && chosen.size() < kMaxSuggestedIsovalues) chosen.push_back(bin);
    }
  }
  const double width = (histogram.high - histogram.low) / static_cast<double>(counts.size());
  std::vector<double> isovalues;
  for (const std::size_t bin : most_informative_first(chosen, counts)) {
    isovalues.push_back(histogram.low + width * static_cast<double>(bin));
  }
  return isovalues;
}

}  // namespace multitetra
