// The allowed error of requests that name none: quality "fine".
#pragma once

namespace multitetra {

inline constexpr double kDefaultError = 0.25;  // In voxels.

}  // namespace multitetra
