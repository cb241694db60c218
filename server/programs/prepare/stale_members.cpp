#include "server/programs/prepare/stale_members.hpp"

#include <algorithm>
#include <exception>
#include <optional>
#include <system_error>

#include "server/dataset/prepared_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// Returns whether the jobs, or options such as --label all, cover the member's place in its series.
bool is_requested(const SeriesMember& member, const SeriesArguments& requested,
                  const std::vector<PrepareJob>& jobs) {
  const bool has_times = requested.all_times || !requested.time_series.empty();
  return std::any_of(jobs.begin(), jobs.end(), [&](const PrepareJob& job) {
    return job.member && job.member->series == member.series && job.member->field == member.field &&
           job.member->label.has_value() == member.label.has_value() &&
           (requested.wants_all_labels() || job.member->label == member.label) &&
           job.member->time.has_value() == member.time.has_value() &&
           (has_times || job.member->time == member.time);
  });
}

std::optional<SeriesMember> member_in(const fs::path& dataset) {
  try {
    return PreparedFile(dataset.string()).info().member;
  } catch (const std::exception&) {  // Keep a file that is not a dataset or is damaged.
    return std::nullopt;
  }
}

}  // namespace

std::vector<fs::path> stale_members(const PrepareArguments& arguments,
                                    const std::vector<PrepareJob>& jobs, const fs::path& folder) {
  std::vector<fs::path> stale;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const fs::path& file = at->path();
    const bool is_made = std::any_of(jobs.begin(), jobs.end(), [&](const PrepareJob& job) {
      return job.output.filename() == file.filename();
    });
    if (file.extension() != ".mtd" || is_made) continue;
    const auto member = member_in(file);
    if (member && is_requested(*member, arguments.series, jobs)) stale.push_back(file);
  }
  std::sort(stale.begin(), stale.end());
  return stale;
}

}  // namespace multitetra
