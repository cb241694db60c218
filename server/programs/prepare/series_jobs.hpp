// The jobs for a series: one per time, field and label.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "server/programs/prepare/prepare_run.hpp"

namespace multitetra {

inline constexpr std::size_t kMaxSeriesJobs = 16'384;

// Requires arguments.series.are_given(). Opens the volumes; reads them for --label all. Groups
// labels by map. `notice` receives warnings. Throws ExitError (kUsage) if a selected member is
// missing, VolumeFileError if a volume cannot be read.
[[nodiscard]] std::vector<PrepareJob> series_jobs(
    const PrepareArguments& arguments, LatestLabelMap& maps,
    const std::function<void(const std::string&)>& notice);

}  // namespace multitetra
