#include "server/volume/volume_folder.hpp"

#include <algorithm>
#include <system_error>

#include "server/volume/formats/described_raw.hpp"
#include "server/volume/formats/volume_formats.hpp"
#include "server/volume/formats/vtk/pvd_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxFolderDepth = 16;

bool is_volume(const fs::path& file) {
  if (is_pvd(file)) return false;  // Its files are there.
  try {
    const VolumeFormat* const format = recognized_format(file);
    if (format == nullptr || !format->is_described) return format != nullptr;
    // A description beside raw samples represents them.
    std::error_code error;
    return !fs::exists(fs::path(file).replace_extension(".dat"), error) ||
           file.extension() == ".dat";
  } catch (const VolumeFileError&) {
    return true;  // Preparing the file reports its error.
  }
}

void collect(const fs::path& folder, int depth, std::vector<fs::path>& volumes) {
  std::vector<fs::path> entries;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    entries.push_back(entry->path());
  }
  if (error) fail_reading(folder, error.message(), "Check its permissions");
  std::sort(entries.begin(), entries.end());
  for (const fs::path& entry : entries) {
    if (entry.filename().string().starts_with('.') || entry.extension() == ".mtd") continue;
    std::error_code ignored;
    if (fs::is_directory(entry, ignored)) {
      if (fs::is_symlink(entry, ignored) || depth == kMaxFolderDepth) continue;
      // A recognized folder is one volume, even if its images are in subfolders.
      if (recognized_format(entry)) {
        volumes.push_back(entry);
      } else {
        collect(entry, depth + 1, volumes);
      }
    } else if (fs::is_regular_file(entry, ignored) && is_volume(entry)) {
      volumes.push_back(entry);
    }
  }
}

}  // namespace

std::vector<fs::path> volumes_in(const fs::path& folder) {
  std::vector<fs::path> volumes;
  collect(folder, 0, volumes);
  return volumes;
}

}  // namespace multitetra
