// Files of a series on disk that were not prepared in this run.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "server/programs/prepare/prepare_arguments.hpp"
#include "server/programs/prepare/prepare_jobs.hpp"

namespace multitetra {

// The datasets in `folder` that an earlier run of the same preparation left: members of a series of
// `jobs`, of one of their fields, at times and with labels that `arguments` ask for, which are no
// longer among the jobs. Other fields of a series, and labels or times that were not asked for, are
// not among them. Requires a folder on this machine.
[[nodiscard]] std::vector<std::filesystem::path> stale_members(const PrepareArguments& arguments,
                                                               const std::vector<PrepareJob>& jobs,
                                                               const std::filesystem::path& folder);

}  // namespace multitetra
