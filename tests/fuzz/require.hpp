// A property that must hold for every input: libFuzzer reports and keeps the input where it does
// not, as it does with everything that is thrown out of a harness.
#pragma once

#include <source_location>
#include <stdexcept>
#include <string>

inline void require(bool holds,
                    const std::source_location& place = std::source_location::current()) {
  if (!holds) {
    throw std::logic_error(std::string("What must hold for every input does not: ") +
                           place.file_name() + ":" + std::to_string(place.line()));
  }
}
