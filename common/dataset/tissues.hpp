// Isovalues of computed tomography by what their surfaces show.
#pragma once

#include <string_view>

#include "common/dataset/dataset_info.hpp"

namespace multitetra {

// Whether the samples are computed tomography: Hounsfield units by name, or, where the unit is
// unknown, a range from air to bone, which hardly anything else has. The viewer knows a CT by the
// same rule.
[[nodiscard]] bool is_ct(const DatasetInfo& info);

// Returns the tissue whose surface an isovalue shows, such as "bone"; the viewer has the same
// names. Empty: unknown.
[[nodiscard]] std::string_view tissue_at(double isovalue, const DatasetInfo& info);

}  // namespace multitetra
