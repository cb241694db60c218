// Suggested isovalues, from a histogram alone.
#pragma once

#include <vector>

#include "common/request/dataset_info.hpp"

namespace multitetra {

// Values that divide the samples into classes as different as possible: the thresholds of N. Otsu,
// "A Threshold Selection Method from Gray-Level Histograms", IEEE Transactions on Systems, Man, and
// Cybernetics 9, 1979, for two, three and four classes (the exact optimum by dynamic programming,
// as in the paper's section on multithresholding). The threshold for two classes comes first, then
// those for three and four that are not redundant, those separated from the chosen ones by a peak
// of the histogram before others. At most 5, each on an edge between bins, strictly inside the
// range of bins that have samples; empty when only one bin has.
[[nodiscard]] std::vector<double> suggested_isovalues(const Histogram& histogram);

}  // namespace multitetra
