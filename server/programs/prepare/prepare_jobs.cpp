#include "server/programs/prepare/prepare_jobs.hpp"

#include <cstdint>
#include <exception>
#include <set>
#include <system_error>

#include "common/base/exit_codes.hpp"
#include "server/dataset/dataset.hpp"
#include "server/dataset/prepared_file.hpp"
#include "server/dataset/section_table.hpp"
#include "server/store/http_store.hpp"
#include "server/volume/formats/volume_formats.hpp"
#include "server/volume/formats/vtk/pvd_file.hpp"
#include "server/volume/volume_folder.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

bool is_multi_volume_folder(const std::string& input) {
  std::error_code error;
  return !is_address(input) && fs::is_directory(input, error) && !recognized_format(input);
}

// Returns a unique name: hydrogen.vti and hydrogen.vtk become hydrogen and hydrogen_vtk.
std::string free_name(const fs::path& input, std::set<std::string>& taken) {
  std::string name = default_dataset_name(input);
  if (taken.contains(name) && input.has_extension())
    name += "_" + input.extension().string().substr(1);
  const std::string base = name;
  for (int i = 2; !taken.insert(name).second; ++i) name = base + "_" + std::to_string(i);
  return name;
}

}  // namespace

std::string label_text(const Label& label) {
  return std::to_string(static_cast<std::int64_t>(label.value));
}

bool is_dataset_file(const std::string& place) {
  if (fs::path(place).extension() != ".mtd") return false;
  return is_address(place) || begins_as_dataset(fs::path(place));
}

bool has_several_volumes(const std::vector<std::string>& inputs) {
  return inputs.size() > 1 || is_pvd(inputs.front()) || is_multi_volume_folder(inputs.front());
}

std::vector<PrepareJob> jobs_for(const std::vector<std::string>& inputs, const fs::path& folder,
                                 bool allow_external_files) {
  std::vector<PrepareJob> jobs;
  std::set<std::string> taken;
  const auto add = [&](const std::string& input) {
    const std::string name = free_name(input, taken);
    jobs.push_back({.input = input, .output = folder / (name + ".mtd"), .name = name});
  };
  for (const std::string& input : inputs) {
    if (is_pvd(input)) {
      for (const CollectedFile& one : files_of_pvd(input, allow_external_files)) {
        add(one.file.string());
        jobs.back().collected_time = one.time;
      }
      continue;
    }
    if (!is_multi_volume_folder(input)) {
      add(input);
      continue;
    }
    for (const fs::path& volume : volumes_in(input)) add(volume.string());
  }
  if (!jobs.empty()) return jobs;
  const std::string& input = inputs.front();
  const bool holds_datasets = is_folder_of_datasets(input) && !datasets_in(input).empty();
  throw ExitError(
      kUsage,
      "There is no volume in " + input +
          (holds_datasets ? ", only datasets. Serve them with: multitetra-server serve " + input
                          : "."));
}

bool is_up_to_date(const PrepareJob& job, const Provenance& note) {
  if (note.digest.empty() || is_address(job.output.string())) return false;
  try {
    std::error_code error;
    const fs::file_time_type made = fs::last_write_time(job.output, error);
    if (error) return false;
    const DatasetMetadata found = PreparedFile(job.output.string()).metadata();
    if (found.source != note || found.info.name != job.name || found.info.member != job.member) {
      return false;
    }
    const fs::path folder =
        fs::path(job.input).has_parent_path() ? fs::path(job.input).parent_path() : ".";
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error)) {
      std::error_code ignored;
      const fs::path& file = entry->path();
      const bool is_digested = file.filename() == fs::path(job.input).filename();
      if (entry->is_regular_file(ignored) && file.extension() != ".mtd" && !is_digested &&
          entry->last_write_time(ignored) > made) {
        return false;
      }
    }
    return !error;
  } catch (const std::exception&) {  // Not a dataset, or damaged.
    return false;
  }
}

}  // namespace multitetra
