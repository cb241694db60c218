// A property that must hold for every input; libFuzzer reports and keeps the input where it does
// not.
#pragma once

#include <cstdlib>

inline void require(bool holds) {
  if (!holds) std::abort();
}
