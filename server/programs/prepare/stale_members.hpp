// Finds datasets of a series that are left from a previous run.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "server/programs/prepare/prepare_arguments.hpp"
#include "server/programs/prepare/prepare_jobs.hpp"

namespace multitetra {

// Returns the datasets in `folder` that an earlier run of the same preparation made and that are
// not among `jobs`: members of the same series and fields, with times and labels that `arguments`
// select. Excludes other fields, labels and times. Requires a local folder.
[[nodiscard]] std::vector<std::filesystem::path> stale_members(const PrepareArguments& arguments,
                                                               const std::vector<PrepareJob>& jobs,
                                                               const std::filesystem::path& folder);

}  // namespace multitetra
