// How much of a large sweep runs: by default the part that has found every fault so far.
#pragma once

#include <cstdlib>
#include <utility>

namespace multitetra::testing {

// Returns `few`, or `all` for `bash tests/run.sh --all`.
template <typename Extent>
Extent sweep(Extent few, Extent all) {
  return std::getenv("MULTITETRA_ALL_TESTS") == nullptr ? std::move(few) : std::move(all);
}

}  // namespace multitetra::testing
