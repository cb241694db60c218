// Statistics of a volume's samples: range, histogram, suggested isovalues.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/core/framework/volume.hpp"
#include "server/dataset/dataset.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

inline constexpr std::size_t kMaxHistogramBins = 256;
inline constexpr std::size_t kMaxSuggestedIsovalues = 5;

struct SampleStatistics {
  double min = 0;  // Over the samples that are not void; 0 when all are void.
  double max = 0;
  std::uint64_t void_samples = 0;  // NaN.
  // At most 256 bins. Integer samples: bins are a whole number of values wide and their edges lie
  // between integers. The counts add up to the samples that are not void.
  Histogram histogram;
  // Up to 5 values strictly between min and max, best first, never an integer when the samples are
  // integers (k + 0.5); empty when all samples are equal.
  std::vector<double> suggested_isovalues;
};

// The same for any number of threads; statistics_builder.hpp does it slab by slab. Throws
// std::invalid_argument when a sample is infinite.
[[nodiscard]] SampleStatistics statistics(const Volume& volume);

// The facts of a volume under a name. Throws std::invalid_argument, naming the argument and its
// range, when the name is not valid, `margin` < 0, `outside` is not finite, or the volume does not
// fit the largest grid.
[[nodiscard]] DatasetInfo describe(const VolumeHeader& header, const SampleStatistics& facts,
                                   std::string name, std::optional<double> outside,
                                   std::int32_t margin);

// The same for a volume in memory. Throws std::invalid_argument also when a sample is infinite.
[[nodiscard]] DatasetInfo describe(const Volume& volume, std::string name,
                                   std::optional<double> outside, std::int32_t margin);

// Whether every field of `info` is in its documented range and they agree with each other.
// kInvalidArgument with one sentence otherwise.
[[nodiscard]] Result<void> check_info(const DatasetInfo& info);

}  // namespace multitetra
