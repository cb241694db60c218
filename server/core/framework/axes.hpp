// Points made axis by axis.
#pragma once

#include "server/core/framework/grid.hpp"

namespace multitetra {

// The point whose coordinates are along(0), along(1) and along(2).
template <typename Along>
[[nodiscard]] constexpr GridPoint by_axis(const Along& along) {
  return {along(0), along(1), along(2)};
}

}  // namespace multitetra
