// The files of the web viewer: one folder, read into memory at the start. Nothing outside of it,
// and nothing that comes into it later, can be reached.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "server/http/answer.hpp"

namespace multitetra {

struct ViewerFileContent {
  SharedBytes bytes;
  SharedBytes gzip;    // Null where there is no NAME.gz beside it.
  SharedBytes brotli;  // Null where there is no NAME.br beside it.
  std::string_view type;
  // A digest of the content, in quotes; encodings have their own.
  std::string tag;
  bool is_named_by_content = false;  // Under /assets/: its name changes with its bytes.
};

class ViewerFiles {
 public:
  // No files: a page that explains this.
  ViewerFiles() = default;
  // Symbolic links are left out. Throws std::filesystem::filesystem_error or std::runtime_error
  // when the folder cannot be read.
  explicit ViewerFiles(const std::filesystem::path& folder);

  [[nodiscard]] bool is_empty() const { return files_.empty(); }
  // By its path as it stands in a request, "/assets/index.js"; "/" is "/index.html". Null: none.
  [[nodiscard]] const ViewerFileContent* find(std::string_view path) const;

 private:
  std::map<std::string, ViewerFileContent, std::less<>> files_;
};

// The files of `folder`; if that is empty, of the viewer that was built or installed beside this
// program, "../share/multitetra/viewer" from its folder, or none. Throws as ViewerFiles does.
[[nodiscard]] std::shared_ptr<const ViewerFiles> find_viewer(const std::filesystem::path& folder);

}  // namespace multitetra
