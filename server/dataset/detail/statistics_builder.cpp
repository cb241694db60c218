#include "server/dataset/detail/statistics_builder.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <type_traits>
#include <variant>

#include "common/base/in_parallel.hpp"
#include "server/dataset/detail/suggested_isovalues.hpp"

namespace multitetra {
namespace {

// Samples that a thread processes at a time.
constexpr std::size_t kPortionSamples = std::size_t{1} << 20;

// Calls body(portion) on all threads for portions of `samples`.
template <typename Sample, typename Body>
void for_portions(std::span<const Sample> samples, const Body& body) {
  const std::size_t portions = (samples.size() + kPortionSamples - 1) / kPortionSamples;
  in_parallel(portions, [&](std::size_t i) {
    const std::size_t begin = i * kPortionSamples;
    body(samples.subspan(begin, std::min(kPortionSamples, samples.size() - begin)));
  });
}

std::size_t values_of(SampleType type) {
  return type == SampleType::kF32 ? 0 : std::size_t{1} << (8 * bytes_per_sample(type));
}

std::int32_t lowest_of(SampleType type) {
  const bool is_signed = type == SampleType::kI8 || type == SampleType::kI16;
  return is_signed ? -static_cast<std::int32_t>(values_of(type) / 2) : 0;
}

// ---- groups of floating-point values: the upper bits of an integer that sorts like the value

constexpr int kGroupBits = 24;
constexpr int kGroupShift = 32 - kGroupBits;
constexpr std::uint32_t kSign = std::uint32_t{1} << 31;

std::uint32_t group_of(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value + 0.0F);  // Turns -0 into 0.
  return ((bits & kSign) != 0 ? ~bits : bits | kSign) >> kGroupShift;
}

float lowest_of_group(std::uint32_t group) {
  const std::uint32_t ordered = group << kGroupShift;
  return std::bit_cast<float>((ordered & kSign) != 0 ? ordered & ~kSign : ~ordered);
}

// Counts how often each value occurs. Neighboring samples are often equal, and a second increment
// of the same counter waits until the first is stored, so neighbors use separate tables.
template <typename Sample>
class ValueTables {
 public:
  void count(std::span<const Sample> samples) {
    std::size_t i = 0;
    for (; i + kTables <= samples.size(); i += kTables) {
      for (std::size_t table = 0; table < kTables; ++table) ++at(table, samples[i + table]);
    }
    for (; i < samples.size(); ++i) ++at(0, samples[i]);
  }

  // Adds the counts to `total`, starting at the lowest value of the type.
  void add_to(std::vector<std::uint64_t>& total) const {
    constexpr std::size_t kLowest = std::is_signed_v<Sample> ? kValues / 2 : 0;
    for (std::size_t value = 0; value < kValues; ++value) {
      std::uint64_t sum = 0;
      for (std::size_t table = 0; table < kTables; ++table) sum += counts_[table * kValues + value];
      total[value ^ kLowest] += sum;
    }
  }

 private:
  using Bits = std::make_unsigned_t<Sample>;
  static constexpr std::size_t kValues = std::size_t{1} << (8 * sizeof(Sample));
  static constexpr std::size_t kTables = sizeof(Sample) == 1 ? 8 : 2;

  std::uint32_t& at(std::size_t table, Sample sample) {
    return counts_[table * kValues + static_cast<Bits>(sample)];
  }

  std::vector<std::uint32_t> counts_ = std::vector<std::uint32_t>(kTables * kValues);
};

}  // namespace

SampleStatisticsBuilder::SampleStatisticsBuilder(SampleType type)
    : type_(type),
      value_counts_(values_of(type)),
      occurs_(type == SampleType::kF32 ? (std::size_t{1} << kGroupBits) / 64 : 0),
      bin_counts_(type == SampleType::kF32 ? kMaxHistogramBins : 0) {}

template <typename Sample>
void SampleStatisticsBuilder::count_values(std::span<const Sample> samples) {
  std::mutex mutex;  // Guards `value_counts_`.
  for_portions(samples, [&](std::span<const Sample> portion) {
    ValueTables<Sample> tables;
    tables.count(portion);
    const std::lock_guard lock(mutex);
    tables.add_to(value_counts_);
  });
}

void SampleStatisticsBuilder::widen_range(std::span<const float> samples) {
  std::mutex mutex;  // Guards `min_`, `max_` and `void_samples_`.
  for_portions(samples, [&](std::span<const float> portion) {
    float min = std::numeric_limits<float>::infinity();
    float max = -min;
    std::uint64_t void_samples = 0;
    for (const float sample : portion) {
      if (std::isnan(sample)) {
        ++void_samples;
        continue;
      }
      min = std::min(min, sample);
      max = std::max(max, sample);
      const std::uint32_t group = group_of(sample);
      std::atomic<std::uint64_t>& word = occurs_[group / 64];
      const std::uint64_t bit = std::uint64_t{1} << (group % 64);
      // Most groups are already marked: reading is cheaper than writing.
      if ((word.load(std::memory_order_relaxed) & bit) == 0) {
        word.fetch_or(bit, std::memory_order_relaxed);
      }
    }
    const std::lock_guard lock(mutex);
    min_ = std::min(min_, min);
    max_ = std::max(max_, max);
    void_samples_ += void_samples;
  });
  samples_ += samples.size();
  const bool none = void_samples_ == samples_;
  if (!none && (std::isinf(min_) || std::isinf(max_))) {
    throw std::invalid_argument(
        "A sample of the volume is infinite; samples must be finite or NaN (void).");
  }
}

void SampleStatisticsBuilder::add_second_pass(std::span<const float> samples) {
  assert(needs_second_pass());
  const double low = min_;
  const double extent = double{max_} - low;
  constexpr std::size_t kBins = kMaxHistogramBins;
  std::mutex mutex;  // Guards `bin_counts_`.
  for_portions(samples, [&](std::span<const float> portion) {
    std::array<std::uint64_t, kBins> counts{};
    for (const float sample : portion) {
      if (std::isnan(sample)) continue;
      const double share = (double{sample} - low) / extent;
      ++counts[std::min(static_cast<std::size_t>(share * kBins), kBins - 1)];
    }
    const std::lock_guard lock(mutex);
    std::transform(counts.begin(), counts.end(), bin_counts_.begin(), bin_counts_.begin(),
                   std::plus<>());
  });
}

void SampleStatisticsBuilder::add(const Samples& slab) {
  assert(static_cast<SampleType>(slab.index()) == type_);
  std::visit(
      [&]<typename Sample>(const std::vector<Sample>& samples) {
        if constexpr (std::is_same_v<Sample, float>) {
          widen_range(samples);
        } else {
          count_values(std::span<const Sample>(samples));
        }
      },
      slab);
}

bool SampleStatisticsBuilder::needs_second_pass() const {
  return type_ == SampleType::kF32 && min_ < max_;
}

SampleStatistics SampleStatisticsBuilder::of_integers() const {
  const auto occurs = [](std::uint64_t count) { return count > 0; };
  const auto& counts = value_counts_;
  auto first =
      static_cast<std::size_t>(std::find_if(counts.begin(), counts.end(), occurs) - counts.begin());
  auto last = static_cast<std::size_t>(counts.rend() -
                                       std::find_if(counts.rbegin(), counts.rend(), occurs) - 1);
  if (first == counts.size()) {  // All samples are void.
    first = last = static_cast<std::size_t>(-lowest_of(type_));
  }
  const std::size_t width = (last - first) / kMaxHistogramBins + 1;  // Values per bin.
  const std::size_t bins = (last - first) / width + 1;
  SampleStatistics result;
  result.min = lowest_of(type_) + static_cast<double>(first);
  result.max = lowest_of(type_) + static_cast<double>(last);
  result.histogram.low = result.min - 0.5;
  result.histogram.high = result.histogram.low + static_cast<double>(bins * width);
  result.histogram.counts.resize(bins);
  for (std::size_t value = first; value <= last; ++value) {
    result.histogram.counts[(value - first) / width] += counts[value];
  }
  return result;
}

SampleStatistics SampleStatisticsBuilder::of_floats() const {
  SampleStatistics result;
  result.void_samples = void_samples_;
  if (void_samples_ < samples_) {
    result.min = double{min_} + 0.0;  // Turns -0 into 0.
    result.max = double{max_} + 0.0;
  }
  if (needs_second_pass()) {
    result.histogram = {result.min, result.max, bin_counts_};
  } else {
    // One bin around the only value: half a unit, or what makes a difference for large numbers.
    const double half = std::max(0.5, std::abs(result.min) * 1e-9);
    result.histogram = {result.min - half, result.max + half, {samples_ - void_samples_}};
  }
  return result;
}

SampleStatistics SampleStatisticsBuilder::finish() const {
  SampleStatistics result = type_ == SampleType::kF32 ? of_floats() : of_integers();
  result.suggested_isovalues = suggested_isovalues(result.histogram);
  return result;
}

std::vector<float> SampleStatisticsBuilder::distinct_values() const {
  std::vector<float> values;
  for (std::size_t value = 0; value < value_counts_.size(); ++value) {
    if (value_counts_[value] == 0) continue;
    values.push_back(static_cast<float>(lowest_of(type_) + static_cast<std::int32_t>(value)));
  }
  for (std::size_t word = 0; word < occurs_.size(); ++word) {
    for (std::uint64_t bits = occurs_[word]; bits != 0; bits &= bits - 1) {
      const auto group = static_cast<std::uint32_t>(64 * word) +
                         static_cast<std::uint32_t>(std::countr_zero(bits));
      values.push_back(std::max(lowest_of_group(group), min_ + 0.0F));
    }
  }
  return values;
}

}  // namespace multitetra
