// The jobs of a command: one per volume, or for series one per time, field and label.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "server/programs/prepare/prepare_run.hpp"

namespace multitetra {

inline constexpr std::size_t kMaxSeriesJobs = 16'384;

// Opens the volumes of series; reads them for --label all. Groups labels by map. `notice` receives
// warnings. Throws ExitError (kUsage) if there is no volume or a selected member is missing,
// VolumeFileError if a volume cannot be read.
[[nodiscard]] std::vector<PrepareJob> jobs_of(
    const PrepareArguments& arguments, LatestLabelMap& maps,
    const std::function<void(const std::string&)>& notice);

}  // namespace multitetra
