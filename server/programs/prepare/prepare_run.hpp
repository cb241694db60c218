// Prepares volumes one after another and prints the results: prepared, up to date or failed.
#pragma once

#include <vector>

#include "server/programs/prepare/detail/preparation.hpp"

namespace multitetra {

// One volume, into one dataset. Returns the exit code. Throws ExitError when it cannot be read.
int prepare_single(const PrepareArguments& arguments, const PrepareJob& job);

// Continues after a failure; datasets that are up to date are skipped. Prints a table at the end.
int prepare_all(const PrepareArguments& arguments, const std::vector<PrepareJob>& jobs,
                LatestLabelMap& maps);

}  // namespace multitetra
