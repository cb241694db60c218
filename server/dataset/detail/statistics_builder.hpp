// The statistics of a volume that comes in slabs.
//
//   SampleStatisticsBuilder builder(source.header().type);
//   for (each slab) builder.add(slab);
//   if (builder.needs_second_pass()) for (each slab) builder.add_again(slab);
//   const SampleStatistics facts = builder.finish();
//
// Guaranteed: the same for any cut into slabs, in any order, and any number of threads. Memory: at
// most 3 MiB and some hundred KiB a thread, whatever the volume.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "server/core/framework/volume.hpp"
#include "server/dataset/detail/statistics.hpp"

namespace multitetra {

class SampleStatisticsBuilder {
 public:
  explicit SampleStatisticsBuilder(SampleType type);

  // The first pass, in which every sample comes once. Requires samples of the builder's type.
  // Throws std::invalid_argument when one is infinite.
  void add(const Samples& slab);

  // Whether every sample must come once more, after the first pass: the range of floating-point
  // samples is known only then. Integers never do.
  [[nodiscard]] bool needs_second_pass() const;

  // The second pass.
  void add_again(const Samples& slab);

  // Requires that the passes are over.
  [[nodiscard]] SampleStatistics finish() const;

  // The distinct values, ascending. Integers: all of them. Floating-point samples: values with the
  // same sign, exponent and first 15 of 23 bits of the fraction are represented once, by the lowest
  // of them (but none below the least sample), so there are at most 2^24. Requires that the first
  // pass is over.
  [[nodiscard]] std::vector<float> distinct_values() const;

 private:
  [[nodiscard]] SampleStatistics of_integers() const;
  [[nodiscard]] SampleStatistics of_floats() const;
  template <typename Sample>
  void count_values(std::span<const Sample> samples);
  void widen_range(std::span<const float> samples);
  void count_bins(std::span<const float> samples);

  SampleType type_;
  // Integers: how often each value occurs, from the lowest value of the type on.
  std::vector<std::uint64_t> value_counts_;
  // Floating-point samples.
  float min_ = std::numeric_limits<float>::infinity();
  float max_ = -std::numeric_limits<float>::infinity();
  std::uint64_t samples_ = 0;
  std::uint64_t void_samples_ = 0;
  std::vector<std::atomic<std::uint64_t>> occurs_;  // A bit for each group of values.
  std::vector<std::uint64_t> bin_counts_;
};

}  // namespace multitetra
