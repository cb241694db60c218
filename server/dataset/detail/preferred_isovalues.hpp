// Isovalues known to matter; they precede those suggested from the histogram.
#pragma once

#include <optional>

#include "common/dataset/dataset_info.hpp"

namespace multitetra {

// Puts known isovalues first among the suggestions: the one the source recommends, then skin and
// bone for CT. Drops values outside the range of the samples and suggestions close to an earlier
// one; keeps at most kMaxSuggestedIsovalues.
void prefer_known_isovalues(const std::optional<double>& recommended, DatasetInfo& info);

}  // namespace multitetra
