// The interface through which core runs independent tasks; the caller chooses the threads.
#pragma once

#include <cstddef>
#include <functional>

namespace multitetra {

// Calls body(0) ... body(count - 1) in any order, possibly concurrently, and returns when all have
// returned. Rethrows an exception of a body.
using ForEach =
    std::function<void(std::size_t count, const std::function<void(std::size_t)>& body)>;

inline void sequentially(std::size_t count, const std::function<void(std::size_t)>& body) {
  for (std::size_t i = 0; i < count; ++i) body(i);
}

}  // namespace multitetra
