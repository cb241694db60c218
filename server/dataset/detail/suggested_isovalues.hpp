// Suggests isovalues from a histogram.
#pragma once

#include <vector>

#include "common/dataset/dataset_info.hpp"

namespace multitetra {

// Returns the values that best separate the samples into classes: the thresholds of N. Otsu, "A
// Threshold Selection Method from Gray-Level Histograms", IEEE Transactions on Systems, Man, and
// Cybernetics 9, 1979, for two, three and four classes (the exact optimum by dynamic programming,
// see the paper's section on multithresholding). The threshold for two classes comes first, then
// non-redundant ones for three and four; those separated from earlier ones by a peak of the
// histogram precede others. Returns at most 5, each on an edge between bins and strictly inside the
// range of bins with samples; none if only one bin has samples.
[[nodiscard]] std::vector<double> suggested_isovalues(const Histogram& histogram);

}  // namespace multitetra
