#include "server/dataset/detail/preferred_isovalues.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/dataset/tissues.hpp"
#include "server/dataset/detail/statistics.hpp"

namespace multitetra {
namespace {

// Halfway between two Hounsfield units. Air is -1000, water 0, compact bone several hundred.
constexpr double kSkin = -300.5;
constexpr double kBone = 300.5;

}  // namespace

void prefer_known_isovalues(const std::optional<double>& recommended, DatasetInfo& info) {
  std::vector<double> preferred;
  const auto add = [&](double isovalue) {
    if (isovalue > info.min && isovalue < info.max) preferred.push_back(isovalue);
  };
  if (recommended) add(*recommended);
  if (is_ct(info)) {
    add(kSkin);
    add(kBone);
  }
  // The same minimum distance as between suggestions from a histogram.
  const double apart = preferred.empty() ? 0 : (info.histogram.high - info.histogram.low) / 25;
  for (const double isovalue : info.suggested_isovalues) {
    const bool is_new = std::none_of(preferred.begin(), preferred.end(), [&](double other) {
      return std::abs(isovalue - other) < apart;
    });
    if (is_new) preferred.push_back(isovalue);
  }
  if (preferred.size() > kMaxSuggestedIsovalues) preferred.resize(kMaxSuggestedIsovalues);
  info.suggested_isovalues = std::move(preferred);
}

}  // namespace multitetra
