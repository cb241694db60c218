// The statistics of a volume that arrives in slabs.
//
//   SampleStatisticsBuilder builder(source.header().type);
//   for (each slab) builder.add(slab);
//   if (builder.needs_second_pass()) for (each slab) builder.add_second_pass(slab);
//   const SampleStatistics facts = builder.finish();
//
// Guaranteed: the result does not depend on how the volume is cut into slabs, their order, or the
// number of threads. Takes at most 3 MiB plus a few hundred KiB per thread, for any volume.
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

  // First pass: add each sample once. Requires samples of the builder's type. Throws
  // std::invalid_argument if one is infinite.
  void add(const Samples& slab);

  // After the first pass: returns whether a second pass is needed. Floating-point samples may need
  // it, since only now is their range known; integers never do.
  [[nodiscard]] bool needs_second_pass() const;

  // Second pass: add each sample again.
  void add_second_pass(std::span<const float> samples);

  // Requires that all passes are complete.
  [[nodiscard]] SampleStatistics finish() const;

  // Returns the distinct values, ascending. Integers: all of them. Floating-point samples: values
  // that share sign, exponent and the first 15 of 23 fraction bits are represented by the lowest of
  // them (but none below the least sample), so there are at most 2^24. Requires the first pass.
  [[nodiscard]] std::vector<float> distinct_values() const;

 private:
  [[nodiscard]] SampleStatistics of_integers() const;
  [[nodiscard]] SampleStatistics of_floats() const;
  template <typename Sample>
  void count_values(std::span<const Sample> samples);
  void widen_range(std::span<const float> samples);

  SampleType type_;
  // Integers: the number of samples of each value, starting at the lowest value of the type.
  std::vector<std::uint64_t> value_counts_;
  // The following are for floating-point samples.
  float min_ = std::numeric_limits<float>::infinity();
  float max_ = -std::numeric_limits<float>::infinity();
  std::uint64_t samples_ = 0;
  std::uint64_t void_samples_ = 0;
  std::vector<std::atomic<std::uint64_t>> occurs_;  // One bit per group of values.
  std::vector<std::uint64_t> bin_counts_;
};

}  // namespace multitetra
