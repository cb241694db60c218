// How many files, of which connections are some, this process may have open at a time.
#pragma once

#include <cstdint>

namespace multitetra {

// Raises the limit as far as the system lets this process, and returns it.
std::uint64_t allow_most_open_files();

}  // namespace multitetra
