// The process's limit of open files, including connections.
#pragma once

#include <cstdint>

namespace multitetra {

// Raises the limit to the maximum allowed by the system, and returns it.
std::uint64_t allow_most_open_files();

}  // namespace multitetra
