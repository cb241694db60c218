// Prepares volumes one after the other and prints the results.
#pragma once

#include <vector>

#include "server/programs/prepare/detail/preparation.hpp"

namespace multitetra {

// Prepares one dataset. Returns the exit code. Throws VolumeFileError if the volume cannot be read.
int prepare_single(const PrepareArguments& arguments, const PrepareJob& job, LatestLabelMap& maps);

// Prepares all jobs, continues after a failure, and skips datasets that are up to date. Prints a
// table at the end.
int prepare_all(const PrepareArguments& arguments, const std::vector<PrepareJob>& jobs,
                LatestLabelMap& maps);

}  // namespace multitetra
