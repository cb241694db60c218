// ParaView collections (.pvd): the files of a time series with their times.
#pragma once

#include <filesystem>
#include <vector>

namespace multitetra {

struct CollectedFile {
  std::filesystem::path file;
  double time = 0;
};

[[nodiscard]] bool is_pvd(const std::filesystem::path& path);

// Returns the files in the order of their times. Files outside the collection's folder need
// `allow_external_files`. Throws VolumeFileError if the collection is damaged or empty, or if a
// time has several parts.
[[nodiscard]] std::vector<CollectedFile> files_of_pvd(const std::filesystem::path& path,
                                                      bool allow_external_files);

}  // namespace multitetra
