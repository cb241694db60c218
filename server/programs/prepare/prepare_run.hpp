// Prepares volumes one after another and prints the results: prepared, up to date or failed.
#pragma once

#include <vector>

#include "server/programs/prepare/detail/preparation.hpp"

namespace multitetra {

// One volume, into one dataset. Returns the exit code. Throws ExitError when it cannot be read.
int prepare_single(const PrepareArguments& arguments, const PrepareJob& job);

// Goes on after a failure; what is up to date is not made again. Ends with a table.
int prepare_all(const PrepareArguments& arguments, const std::vector<PrepareJob>& jobs,
                LatestLabelMap& maps);

}  // namespace multitetra
