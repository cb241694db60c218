// The interface by which core runs independent tasks: core says what is independent, the caller
// decides on threads.
#pragma once

#include <cstddef>
#include <functional>

namespace multitetra {

// Calls body(0) ... body(count - 1), in any order and possibly at the same time, and returns when
// all have returned. An exception of a body leaves the call.
using ForEach =
    std::function<void(std::size_t count, const std::function<void(std::size_t)>& body)>;

inline void sequentially(std::size_t count, const std::function<void(std::size_t)>& body) {
  for (std::size_t i = 0; i < count; ++i) body(i);
}

}  // namespace multitetra
