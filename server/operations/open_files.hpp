// The limit of open files of this process, connections included.
#pragma once

#include <cstdint>

namespace multitetra {

// Raises the limit as far as the system lets this process, and returns it.
std::uint64_t allow_most_open_files();

}  // namespace multitetra
