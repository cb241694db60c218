// The datasets of a series: one for each time, field and label.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "server/programs/prepare/prepare_run.hpp"

namespace multitetra {

inline constexpr std::size_t kMostSeriesJobs = 16'384;

// Requires arguments.series.are_given(). Looks into the volumes, and with --label all reads them.
// Labels of one map follow each other. `notice` receives warnings. Throws ExitError
// (kUsage) when a selected member is missing, VolumeFileError when a volume cannot be read.
[[nodiscard]] std::vector<PrepareJob> series_jobs(
    const PrepareArguments& arguments, LatestLabelMap& maps,
    const std::function<void(const std::string&)>& notice);

}  // namespace multitetra
