// Isovalues worth a look, from a histogram alone.
#pragma once

#include <vector>

#include "common/request/dataset_info.hpp"

namespace multitetra {

// Values that part the samples into classes as unlike as possible: the thresholds of N. Otsu, "A
// Threshold Selection Method from Gray-Level Histograms", IEEE Transactions on Systems, Man, and
// Cybernetics 9, 1979, for two, three and four classes (the exact optimum by dynamic programming,
// as the paper's section on multithresholding asks for). The threshold for two classes comes first,
// then those for three and four that tell something new: before others those between which and all
// before lies a hill of the histogram. At most 5, each on an edge between bins,
// strictly inside the range of bins that have samples; empty when only one bin has.
[[nodiscard]] std::vector<double> suggested_isovalues(const Histogram& histogram);

}  // namespace multitetra
