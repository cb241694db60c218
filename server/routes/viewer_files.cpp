#include "server/routes/viewer_files.hpp"

#include <iterator>
#include <stdexcept>

#include "common/base/open_file.hpp"
#include "server/http/http_response.hpp"
#include "server/http/media.hpp"

namespace multitetra {
namespace {

SharedBytes bytes_of(const std::filesystem::path& file) {
  auto bytes = OpenFile(file).content(SIZE_MAX);
  if (!bytes) throw std::runtime_error("Cannot read the viewer's file '" + file.string() + "'.");
  return std::make_shared<const std::string>(*std::move(bytes));
}

}  // namespace

ViewerFiles::ViewerFiles(const std::filesystem::path& folder) {
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_symlink() || !entry.is_regular_file()) continue;
    const std::string name = entry.path().lexically_relative(folder).generic_string();
    const SharedBytes bytes = bytes_of(entry.path());
    files_["/" + name] = {.bytes = bytes,
                          .gzip = nullptr,
                          .brotli = nullptr,
                          .type = media_type_of_file(name),
                          .tag = tag_of(*bytes),
                          .is_named_by_content = name.starts_with("assets/")};
  }
  for (auto& [name, file] : files_) {
    if (const auto gzip = files_.find(name + ".gz"); gzip != files_.end()) {
      file.gzip = gzip->second.bytes;
    }
    if (const auto brotli = files_.find(name + ".br"); brotli != files_.end()) {
      file.brotli = brotli->second.bytes;
    }
  }
}

const ViewerFileContent* ViewerFiles::find(std::string_view path) const {
  const auto found = files_.find(path == "/" ? std::string_view("/index.html") : path);
  return found == files_.end() ? nullptr : &found->second;
}

std::filesystem::path viewer_folder() {
  std::error_code unknown;  // Without /proc the program's path is unknown.
  const auto program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  const auto own = program.parent_path().parent_path() / "share" / "multitetra" / "viewer";
  return unknown || !std::filesystem::is_directory(own) ? std::filesystem::path() : own;
}

std::shared_ptr<const ViewerFiles> find_viewer(const std::filesystem::path& folder) {
  const std::filesystem::path found = folder.empty() ? viewer_folder() : folder;
  return found.empty() ? std::make_shared<const ViewerFiles>()
                       : std::make_shared<const ViewerFiles>(found);
}

}  // namespace multitetra
