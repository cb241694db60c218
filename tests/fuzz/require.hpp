// A property that must hold for every input: libFuzzer reports and keeps the input where it does
// not, as it does with everything that is thrown out of a harness.
#pragma once

#include <stdexcept>
#include <string>

// The place is that of the call. Clang 14 has the builtins and no std::source_location.
inline void require(bool holds, const char* file = __builtin_FILE(),
                    int line = __builtin_LINE()) {
  if (!holds) {
    throw std::logic_error(std::string("A property does not hold: ") + file + ":" +
                           std::to_string(line));
  }
}
