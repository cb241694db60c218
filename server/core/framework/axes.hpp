// Construction of points axis by axis.
#pragma once

#include "server/core/framework/grid.hpp"

namespace multitetra {

// Returns the point with the coordinates along(0), along(1) and along(2).
template <typename Along>
[[nodiscard]] constexpr GridPoint by_axis(const Along& along) {
  return {along(0), along(1), along(2)};
}

}  // namespace multitetra
