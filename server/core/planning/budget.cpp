#include "server/core/planning/budget.hpp"

#include <algorithm>
#include <cmath>

namespace multitetra {
namespace {

constexpr int kLevelsPerOctave = 4;
constexpr int kFirstOctave = -4;  // A sixteenth of a voxel.
// Estimates are off by about ten percent: the target leaves a margin.
constexpr double kBudgetMargin = 0.9;
// The target of the search among surfaces that were actually built.
constexpr double kGoal = 0.85;

// In voxels. Products of exact numbers, which give the same bits on every machine.
double floor_of(int index) {
  constexpr double kParts[kLevelsPerOctave] = {1, 1.189207115002721, 1.4142135623730951,
                                               1.681792830507429};
  return std::ldexp(kParts[index % kLevelsPerOctave], kFirstOctave + index / kLevelsPerOctave);
}

// Returns the binary logarithm, linear between powers of two: within 0.09 of the exact value, with
// the same bits on every machine. Requires x > 0.
double rough_log2(double x) {
  int exponent = 0;
  const double mantissa = std::frexp(x, &exponent);
  return exponent - 1 + (2 * mantissa - 1);
}

// Returns a lower bound of the request's thresholds.
double least_threshold(const IsosurfaceRequest& request) {
  double least = request.error;
  const LocalThresholds& local = request.thresholds;
  for (const ThresholdRegion& region : local.regions) least = std::min(least, region.threshold);
  if (local.grid) {
    for (const float threshold : local.grid->thresholds) {
      least = std::min(least, static_cast<double>(threshold));
    }
  }
  if (local.view) least = 0;
  return std::max(least, local.error_floor);
}

}  // namespace

double part_of_budget(const SurfaceSize& size, const IsosurfaceRequest& request) {
  const auto part = [](double used, std::uint64_t limit) {
    return limit == 0 ? 0 : used / static_cast<double>(limit);
  };
  return std::max(part(size.triangles, request.max_triangles), part(size.bytes, request.max_bytes));
}

ErrorSchedule::ErrorSchedule(const IsosurfaceRequest& request, const DatasetInfo& info)
    : request_(request),
      unit_(request.unit == ErrorUnit::kVoxel ? 1.0 : voxel_length(info)),
      floors_(kLevelsPerOctave * (info.grid_exponent - kFirstOctave) + 1) {
  const double least = least_threshold(request);
  while (below_ + 1 < floors_ && unit_ * floor_of(below_) <= least) ++below_;
}

IsosurfaceRequest ErrorSchedule::at(int level) const {
  IsosurfaceRequest result = request_;
  if (level > 0) {
    result.thresholds.error_floor =
        std::max(request_.thresholds.error_floor, unit_ * floor_of(below_ + level - 1));
  }
  return result;
}

int ErrorSchedule::lowest_fitting(const SizeOf& size_of, int from, int to, double part) const {
  if (!has_budget(request_)) return 0;
  const auto fits_at = [&](int level) {
    return part_of_budget(size_of({.request = at(level)}), request_) <= part;
  };
  while (from < to) {
    const int middle = (from + to) / 2;
    if (fits_at(middle)) {
      to = middle;
    } else {
      from = middle + 1;
    }
  }
  return to;
}

int ErrorSchedule::lowest_fitting(const SizeOf& estimate) const {
  if (!has_budget(request_)) return 0;
  const double all = part_of_budget(estimate({.request = request_}), request_);
  return all <= kBudgetMargin ? 0 : lowest_fitting(estimate, 1, last(), kBudgetMargin);
}

int next_level(const std::optional<TriedLevel>& too_large, const std::optional<TriedLevel>& fitting,
               int estimated, int last) {
  // Avoids the logarithm of an empty surface.
  const auto octaves = [](const TriedLevel& made) {
    return rough_log2(std::max(made.part, 1e-9) / kGoal);
  };
  const int lowest = too_large ? too_large->level + 1 : 0;
  const int highest = fitting ? fitting->level - 1 : last;
  const auto whole = [](double levels) {
    return static_cast<int>(std::clamp(std::round(levels), -1000.0, 1000.0));
  };
  int level = estimated;
  if (too_large && fitting) {
    const double above = octaves(*too_large);
    const double share = above / std::max(above - octaves(*fitting), 1e-9);
    level = too_large->level + whole(share * (fitting->level - too_large->level));
  } else if (too_large) {
    const double above = kLevelsPerOctave * octaves(*too_large);
    level = std::clamp(estimated, too_large->level + whole(above / 4),
                       too_large->level + whole(4 * above));
  } else if (fitting) {
    const double below = -kLevelsPerOctave * octaves(*fitting);
    level = std::clamp(estimated, fitting->level - whole(below), fitting->level - whole(below / 4));
  }
  return std::clamp(level, lowest, highest);
}

int coarser_level(const std::optional<TriedLevel>& before, const TriedLevel& made, int last) {
  constexpr double kOctavesPerLevel = 0.2;
  const double above = rough_log2(made.part);
  double octaves_per_level = kOctavesPerLevel;
  if (before) {
    const double fell = rough_log2(before->part) - above;
    octaves_per_level = std::clamp(fell / (made.level - before->level), 0.02, 0.5);
  }
  const double levels =
      std::clamp(std::ceil(above / octaves_per_level), 1.0, 4.0 * kLevelsPerOctave);
  return std::min(made.level + static_cast<int>(levels), last);
}

int finer_level(const TriedLevel& made) {
  const double below = -rough_log2(std::max(made.part, 1e-9));
  return std::max(made.level - static_cast<int>(kLevelsPerOctave * (1 + std::ceil(below))), 0);
}

IsosurfaceRequest within_budget(const IsosurfaceRequest& request, const DatasetInfo& info,
                                const ErrorSchedule::SizeOf& estimate) {
  const ErrorSchedule schedule(request, info);
  return schedule.at(schedule.lowest_fitting(estimate));
}

}  // namespace multitetra
