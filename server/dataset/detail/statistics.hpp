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
  double min = 0;  // Over the samples that are not void; 0 if all are void.
  double max = 0;
  std::uint64_t void_samples = 0;  // Samples that are NaN.
  // At most 256 bins. For integer samples each bin spans a whole number of values and its edges lie
  // between integers. The counts sum up to the samples that are not void.
  Histogram histogram;
  // Up to 5 values strictly between min and max, best first; k + 0.5 for integer samples; empty if
  // all samples are equal.
  std::vector<double> suggested_isovalues;
};

// Returns the same result for any number of threads; statistics_builder.hpp computes it slab by
// slab. Throws std::invalid_argument if a sample is infinite.
[[nodiscard]] SampleStatistics statistics(const Volume& volume);

// Describes a volume as a dataset. Throws std::invalid_argument, naming the argument and its range,
// if the name is invalid, `margin` < 0, `outside` is not finite, or the volume is too large.
[[nodiscard]] DatasetInfo describe(const VolumeHeader& header, const SampleStatistics& facts,
                                   std::string name, std::optional<double> outside,
                                   std::int32_t margin);

// Returns the same for a volume in memory. Also throws std::invalid_argument if a sample is
// infinite.
[[nodiscard]] DatasetInfo describe(const Volume& volume, std::string name,
                                   std::optional<double> outside, std::int32_t margin);

// Checks that every field is in its documented range and that the fields are consistent. Returns
// kInvalidArgument with one sentence otherwise.
[[nodiscard]] Result<void> check_info(const DatasetInfo& info);

}  // namespace multitetra
