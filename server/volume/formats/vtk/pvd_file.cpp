#include "server/volume/formats/vtk/pvd_file.hpp"

#include <algorithm>
#include <string>

#include "common/base/number_text.hpp"
#include "server/volume/formats/detail/input_file.hpp"
#include "server/volume/formats/stored_volume.hpp"
#include "server/volume/formats/vtk/detail/vti_header.hpp"

namespace multitetra {

bool is_pvd(const std::filesystem::path& path) { return path.extension() == ".pvd"; }

std::vector<CollectedFile> files_of_pvd(const std::filesystem::path& path,
                                        bool allow_external_files) {
  constexpr std::size_t kMaxBytes = std::size_t{1} << 24;
  const InputFile file(path);
  const Result<std::vector<PvdEntry>> entries = parse_pvd(file.beginning(kMaxBytes));
  if (!entries) fail_reading(path, entries.error().text, "Save it again");
  std::vector<CollectedFile> files;
  for (const PvdEntry& entry : *entries) {
    files.push_back({named_data_file(path, entry.file, allow_external_files), entry.time});
  }
  std::stable_sort(files.begin(), files.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  const auto twice = std::adjacent_find(
      files.begin(), files.end(), [](const auto& a, const auto& b) { return a.time == b.time; });
  if (twice != files.end()) {
    fail_reading(path, "it has several files of time " + shortest_text(twice->time),
                 "Save one file for each time, such as a .pvti file of all parts");
  }
  return files;
}

}  // namespace multitetra
