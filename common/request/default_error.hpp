// The allowed error where a request names none: quality "fine".
#pragma once

namespace multitetra {

inline constexpr double kDefaultError = 0.25;  // Voxels.

}  // namespace multitetra
