#include "server/dataset/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string_view>
#include <type_traits>
#include <utility>

#include "common/utf8.hpp"
#include "server/dataset/in_parallel.hpp"
#include "server/dataset/suggested_isovalues.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kBins = 256;
constexpr std::size_t kPortion = std::size_t{1} << 20;  // Samples that one thread takes at a time.

// One Partial for each portion of the samples, filled by fill(partial, begin, end), in order. The
// order makes the result independent of the threads.
template <typename Partial, typename Fill>
std::vector<Partial> for_portions(std::size_t count, const Partial& start, const Fill& fill) {
  // Few enough portions that the partials of 16-bit data stay small beside the samples.
  const std::size_t portions = std::clamp<std::size_t>(count / kPortion, 1, 64);
  std::vector<Partial> partials(portions, start);
  in_parallel(portions, [&](std::size_t i) {
    fill(partials[i], count * i / portions, count * (i + 1) / portions);
  });
  return partials;
}

std::vector<std::uint64_t> sum(const std::vector<std::vector<std::uint64_t>>& partials) {
  std::vector<std::uint64_t> total = partials.front();
  for (std::size_t i = 1; i < partials.size(); ++i) {
    std::transform(total.begin(), total.end(), partials[i].begin(), total.begin(), std::plus<>());
  }
  return total;
}

// ---- integer samples: how often each value occurs says everything

template <typename Sample>
SampleStatistics of_integers(const std::vector<Sample>& samples) {
  constexpr std::int32_t kLowest = std::numeric_limits<Sample>::min();
  constexpr std::size_t kValues = std::size_t{1} << (8 * sizeof(Sample));
  const auto counts = sum(
      for_portions(samples.size(), std::vector<std::uint64_t>(kValues),
                   [&](std::vector<std::uint64_t>& partial, std::size_t begin, std::size_t end) {
                     for (std::size_t i = begin; i < end; ++i) {
                       ++partial[static_cast<std::size_t>(std::int32_t{samples[i]} - kLowest)];
                     }
                   }));
  const auto occurs = [](std::uint64_t count) { return count > 0; };
  const auto first =
      static_cast<std::size_t>(std::find_if(counts.begin(), counts.end(), occurs) - counts.begin());
  const auto last = static_cast<std::size_t>(
      counts.rend() - std::find_if(counts.rbegin(), counts.rend(), occurs) - 1);

  const std::size_t width = (last - first) / kBins + 1;  // Values to a bin.
  const std::size_t bins = (last - first) / width + 1;
  SampleStatistics result;
  result.min = static_cast<double>(kLowest) + static_cast<double>(first);
  result.max = static_cast<double>(kLowest) + static_cast<double>(last);
  result.histogram.low = result.min - 0.5;
  result.histogram.high = result.histogram.low + static_cast<double>(bins * width);
  result.histogram.counts.resize(bins);
  for (std::size_t value = first; value <= last; ++value) {
    result.histogram.counts[(value - first) / width] += counts[value];
  }
  return result;
}

// ---- floating-point samples: the range first, then the bins

struct Range {
  float min = std::numeric_limits<float>::infinity();
  float max = -std::numeric_limits<float>::infinity();
  std::uint64_t void_samples = 0;
};

Range range_of(const std::vector<float>& samples) {
  const auto partials =
      for_portions(samples.size(), Range{}, [&](Range& range, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          if (std::isnan(samples[i])) {
            ++range.void_samples;
          } else {
            range.min = std::min(range.min, samples[i]);
            range.max = std::max(range.max, samples[i]);
          }
        }
      });
  Range range;
  for (const Range& partial : partials) {
    range.min = std::min(range.min, partial.min);
    range.max = std::max(range.max, partial.max);
    range.void_samples += partial.void_samples;
  }
  return range;
}

SampleStatistics of_floats(const std::vector<float>& samples) {
  const Range range = range_of(samples);
  SampleStatistics result;
  result.void_samples = range.void_samples;
  if (range.void_samples < samples.size()) {
    result.min = double{range.min} + 0.0;  // No -0.
    result.max = double{range.max} + 0.0;
  }
  Histogram& histogram = result.histogram;
  if (std::isinf(result.min) || std::isinf(result.max)) {
    throw std::invalid_argument(
        "A volume's samples are finite or NaN (void), and one is infinite.");
  }
  if (result.min == result.max) {
    histogram = {result.min - 0.5, result.max + 0.5, {samples.size() - range.void_samples}};
    return result;
  }
  histogram.low = result.min;
  histogram.high = result.max;
  const double extent = result.max - result.min;
  histogram.counts = sum(
      for_portions(samples.size(), std::vector<std::uint64_t>(kBins),
                   [&](std::vector<std::uint64_t>& partial, std::size_t begin, std::size_t end) {
                     for (std::size_t i = begin; i < end; ++i) {
                       if (std::isnan(samples[i])) continue;
                       const double share = (double{samples[i]} - result.min) / extent;
                       ++partial[std::min(static_cast<std::size_t>(share * kBins), kBins - 1)];
                     }
                   }));
  return result;
}

// ---- the facts of a dataset

std::optional<std::string> problem_of_name(std::string_view name) {
  if (name.empty() || name.size() > 255) {
    return "A dataset's name has 1 to 255 bytes, not " + std::to_string(name.size()) + ".";
  }
  while (!name.empty()) {
    const auto byte = static_cast<unsigned char>(name[0]);
    const std::size_t length = utf8_sequence(name);
    if (length == 0 || byte == '/' || byte < 0x20 || byte == 0x7F) {
      return "A dataset's name is UTF-8 without '/' and control characters, and this one has "
             "byte " +
             std::to_string(byte) + ".";
    }
    name.remove_prefix(length);
  }
  return std::nullopt;
}

std::optional<std::string> problem_of_grid(const DatasetInfo& info) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (info.dims[axis] < 1 || info.dims[axis] > (1 << kMaxGridExponent) + 1) {
      return "A dataset has 1 to " + std::to_string((1 << kMaxGridExponent) + 1) +
             " samples a side, not " + std::to_string(info.dims[axis]) + ".";
    }
    if (!std::isfinite(info.spacing[axis]) || info.spacing[axis] <= 0) {
      return "A dataset's spacing is greater than 0, not " + std::to_string(info.spacing[axis]) +
             ".";
    }
  }
  if (info.margin < 0 || info.margin > 1 << kMaxGridExponent) {
    return "The margin is 0 to " + std::to_string(1 << kMaxGridExponent) + " grid steps, not " +
           std::to_string(info.margin) + ".";
  }
  const std::int32_t exponent = grid_exponent_for(info.dims, info.margin);
  if (exponent > kMaxGridExponent) {
    return "The data with a margin of " + std::to_string(info.margin) +
           " does not fit the largest grid of " + std::to_string(1 << kMaxGridExponent) +
           " steps a side.";
  }
  if (info.grid_exponent != exponent) {
    return "The grid exponent is " + std::to_string(exponent) + " for these dims and margin, not " +
           std::to_string(info.grid_exponent) + ".";
  }
  const double volume = info.index_to_world.determinant();
  const Vec3& origin = info.index_to_world.translation;
  const bool finite =
      std::all_of(origin.begin(), origin.end(), [](double x) { return std::isfinite(x); });
  if (!std::isfinite(volume) || volume == 0 || !finite) {
    return "The map from samples to the world is not finite or does not span space.";
  }
  return std::nullopt;
}

std::optional<std::string> problem_of_values(const DatasetInfo& info) {
  if (info.outside && !(std::abs(*info.outside) <= std::numeric_limits<float>::max())) {
    return "The value outside the data is a number that a 32-bit float holds; leave it out for "
           "void.";
  }
  if (!std::isfinite(info.min) || !std::isfinite(info.max) || info.min > info.max) {
    return "The range of the samples is two finite numbers in order.";
  }
  std::uint64_t samples = 1;
  for (const std::int32_t side : info.dims) samples *= static_cast<std::uint64_t>(side);
  const auto& counts = info.histogram.counts;
  if (counts.empty() || counts.size() > kBins || !std::isfinite(info.histogram.low) ||
      !std::isfinite(info.histogram.high) || info.histogram.low >= info.histogram.high) {
    return "The histogram has 1 to " + std::to_string(kBins) + " bins over a range of values.";
  }
  std::uint64_t counted = info.void_samples;
  for (const std::uint64_t count : counts) {
    if (count > samples || counted > samples) break;
    counted += count;
  }
  if (counted != samples) {
    return "The histogram's counts and the void samples do not add up to the number of samples.";
  }
  const auto& isovalues = info.suggested_isovalues;
  if (isovalues.size() > kMaxSuggestedIsovalues ||
      !std::all_of(isovalues.begin(), isovalues.end(), [](double x) { return std::isfinite(x); })) {
    return "At most " + std::to_string(kMaxSuggestedIsovalues) +
           " isovalues are suggested, all of them finite.";
  }
  return std::nullopt;
}

}  // namespace

SampleStatistics statistics(const Volume& volume) {
  SampleStatistics result = std::visit(
      [](const auto& samples) {
        if constexpr (std::is_same_v<std::decay_t<decltype(samples)>, std::vector<float>>) {
          return of_floats(samples);
        } else {
          return of_integers(samples);
        }
      },
      volume.samples);
  result.suggested_isovalues = suggested_isovalues(result.histogram);
  return result;
}

std::optional<std::string> first_problem(const DatasetInfo& info) {
  if (auto problem = problem_of_name(info.name)) return problem;
  if (auto problem = problem_of_grid(info)) return problem;
  return problem_of_values(info);
}

DatasetInfo describe(const Volume& volume, std::string name, std::optional<double> outside,
                     std::int32_t margin) {
  const SampleStatistics facts = statistics(volume);
  DatasetInfo info = {.name = std::move(name),
                      .dims = volume.dims,
                      .type = volume.type(),
                      .spacing = volume.spacing,
                      .index_to_world = volume.index_to_world,
                      .min = facts.min,
                      .max = facts.max,
                      .void_samples = facts.void_samples,
                      .outside = outside,
                      .margin = margin,
                      .grid_exponent = grid_exponent_for(volume.dims, std::max(margin, 0)),
                      .histogram = facts.histogram,
                      .suggested_isovalues = facts.suggested_isovalues};
  if (const auto problem = first_problem(info)) throw std::invalid_argument(*problem);
  return info;
}

DatasetPtr make_dataset(Volume volume, std::string name, std::optional<double> outside,
                        std::int32_t margin) {
  DatasetInfo info = describe(volume, std::move(name), outside, margin);
  return std::make_shared<const Dataset>(Dataset{std::move(info), std::move(volume)});
}

}  // namespace multitetra
