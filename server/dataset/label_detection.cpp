#include "server/dataset/label_detection.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <unordered_map>
#include <vector>

namespace multitetra {
namespace {

constexpr std::size_t kMaxBricks = 1024;
// The threshold of the fraction of a value's pairs of neighbors that have the value on both sides.
// In label maps the median of this fraction over all values is above 0.6, even for balls of radius
// 3; in CT, MR and simulations with 8 bits it is below 0.06.
constexpr double kEqualNeighbors = 0.3;
// A smooth field of integers also has regions, but its neighbors differ by one. Labels this many
// touch the background, and each other in any order.
constexpr std::size_t kManyValues = 16;
constexpr double kStepsOfOne = 0.95;  // Of the neighbors that differ.

struct Neighbors {
  std::uint64_t equal = 0;
  std::uint64_t other = 0;

  [[nodiscard]] std::uint64_t all() const { return equal + other; }
};

class NeighborCensus {
 public:
  // Returns false if a sample is no integer. Void samples are skipped.
  template <typename Sample>
  bool add(const GridCounts& extent, const std::vector<Sample>& brick) {
    const std::array<std::size_t, 3> counts{static_cast<std::size_t>(extent[0]),
                                            static_cast<std::size_t>(extent[1]),
                                            static_cast<std::size_t>(extent[2])};
    const std::array<std::size_t, 3> steps{1, counts[0], counts[0] * counts[1]};
    for (std::size_t at = 0; at < brick.size(); ++at) {
      const auto value = static_cast<float>(brick[at]);
      if (std::isnan(value)) continue;
      if (value != std::trunc(value)) return false;
      Neighbors& own = neighbors_[value];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (at / steps[axis] % counts[axis] + 1 == counts[axis]) continue;
        const auto next = static_cast<float>(brick[at + steps[axis]]);
        if (next == value) {
          ++own.equal;
        } else {
          ++own.other;
          ++different_;
          if (std::abs(next - value) == 1) ++different_by_one_;
          if (!std::isnan(next)) ++neighbors_[next].other;
        }
      }
    }
    return true;
  }

  [[nodiscard]] bool has_regions() const {
    std::vector<double> parts;
    for (const auto& [value, neighbors] : neighbors_) {
      if (neighbors.all() == 0) continue;
      parts.push_back(static_cast<double>(neighbors.equal) / static_cast<double>(neighbors.all()));
    }
    if (parts.size() < 2) return false;
    if (parts.size() >= kManyValues &&
        static_cast<double>(different_by_one_) >= kStepsOfOne * static_cast<double>(different_)) {
      return false;
    }
    const auto median = parts.begin() + static_cast<std::ptrdiff_t>(parts.size() / 2);
    std::nth_element(parts.begin(), median, parts.end());
    return *median >= kEqualNeighbors;
  }

 private:
  // References stay valid while others are added.
  std::unordered_map<float, Neighbors> neighbors_;
  std::uint64_t different_ = 0;
  std::uint64_t different_by_one_ = 0;
};

}  // namespace

bool looks_like_labels(const DatasetInfo& info, const BrickSource& samples) {
  if (info.member) return false;  // Members of a series are times, fields or labels.
  const BrickLayout layout(info.dims);
  const std::size_t step = (layout.size() + kMaxBricks - 1) / kMaxBricks;
  NeighborCensus census;
  return visit_type(info.type,
                    [&]<typename Sample>(const Sample*) {
                      std::vector<Sample> brick;
                      for (std::size_t at = 0; at < layout.size(); at += step) {
                        const RetainedBytes bytes = samples.brick(at);
                        brick.resize(bytes.size() / sizeof(Sample));
                        std::memcpy(brick.data(), bytes.data(), brick.size() * sizeof(Sample));
                        if (!census.add(layout.extent(layout.at(at)), brick)) return false;
                      }
                      return true;
                    }) &&
         census.has_regions();
}

}  // namespace multitetra
