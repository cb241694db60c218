#include "server/volume/detail/readable_files.hpp"

#include <cstddef>
#include <system_error>

#include "server/store/http_options.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxEntries = 200'000;  // In which links are looked for.

// Adds the targets of links in a folder; also in its subfolders if these belong to the source.
template <typename Iterator>
void add_targets(const fs::path& folder, std::vector<fs::path>& files) {
  std::error_code error;
  std::size_t entries = 0;
  for (Iterator at(folder, error), end; !error && at != end && ++entries <= kMaxEntries;
       at.increment(error)) {
    std::error_code gone;
    if (!at->is_symlink(gone)) continue;
    const fs::path target = fs::canonical(at->path(), gone);
    if (!gone) files.push_back(target);
  }
}

}  // namespace

std::vector<fs::path> readable_files(const fs::path& source, bool allow_external_files) {
  if (is_address(source.string())) return {};
  if (allow_external_files) return {"/"};
  std::error_code none;
  std::vector<fs::path> files = {source};
  if (fs::is_directory(source, none)) {
    add_targets<fs::recursive_directory_iterator>(source, files);
    fs::path description = fs::weakly_canonical(source, none);  // Of N5, by BigDataViewer.
    files.push_back(description.replace_extension(".xml"));
    return files;
  }
  const fs::path folder = source.has_parent_path() ? source.parent_path() : fs::path(".");
  files.push_back(folder);
  files.push_back(folder / ".." / "header");  // EMDB's place for the contour levels of maps.
  add_targets<fs::directory_iterator>(folder, files);
  return files;
}

}  // namespace multitetra
