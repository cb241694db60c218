// ParaView collections (.pvd): the files of a time series with their times.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.hpp"

namespace multitetra {

struct PvdEntry {
  std::string file;  // As in the collection.
  double time = 0;   // Finite.
};
// Returns at least one entry, at most kMaxSourceMembers, or an error with a sentence.
[[nodiscard]] Result<std::vector<PvdEntry>> parse_pvd(std::string_view text);

// Returns the entries that a sandboxed reader sends, in the same ranges; nullopt for other bytes.
[[nodiscard]] std::optional<std::vector<PvdEntry>> pvd_entries_from(std::string_view answer);

struct CollectedFile {
  std::filesystem::path file;
  double time = 0;
};

[[nodiscard]] bool is_pvd(const std::filesystem::path& path);

// Reads the collection in a sandbox, and returns the files in the order of their times. Files
// outside the collection's folder need `allow_external_files`. Throws VolumeFileError if the
// collection is damaged or empty, or if a time has several parts.
[[nodiscard]] std::vector<CollectedFile> files_of_pvd(const std::filesystem::path& path,
                                                      bool allow_external_files);

}  // namespace multitetra
