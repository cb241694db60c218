// Checks a property that must hold for every input. libFuzzer reports and stores inputs that
// violate it, as with any exception from a harness.
#pragma once

#include <stdexcept>
#include <string>

// Reports the location of the call. Clang 14 has the builtins but no std::source_location.
inline void require(bool holds, const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  if (!holds) {
    throw std::logic_error(std::string("A property does not hold: ") + file + ":" +
                           std::to_string(line));
  }
}
