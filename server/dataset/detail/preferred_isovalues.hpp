// Isovalues known to matter, before those that a histogram suggests.
#pragma once

#include <optional>

#include "common/request/dataset_info.hpp"

namespace multitetra {

// Whether the samples are computed tomography: Hounsfield units by name, or, where the unit is
// unknown, a range from air to bone, which hardly anything else has. The viewer knows a CT by the
// same rule.
[[nodiscard]] bool is_ct(const DatasetInfo& info);

// Puts what is known about the values first among the suggested isovalues: what the source
// recommends, then skin and bone of a CT. Values outside the samples' range are left out, and so
// are suggestions that hardly differ from one before them; at most kMaxSuggestedIsovalues stay.
void prefer_known_isovalues(const std::optional<double>& recommended, DatasetInfo& info);

}  // namespace multitetra
