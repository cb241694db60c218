// The files of the web viewer: one folder, read into memory at the start. No other file can be
// reached, nor one added later.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "server/http/http_response.hpp"

namespace multitetra {

struct ViewerFileContent {
  SharedBytes bytes;
  SharedBytes gzip;    // Null if there is no NAME.gz.
  SharedBytes brotli;  // Null if there is no NAME.br.
  std::string_view type;
  // A quoted digest of the content; encodings have separate tags.
  std::string tag;
  bool is_named_by_content = false;  // Under /assets/: the name changes with the bytes.
};

class ViewerFiles {
 public:
  // Contains no files.
  ViewerFiles() = default;
  // Reads a folder, ignoring symbolic links. Throws std::filesystem::filesystem_error or
  // std::runtime_error if it cannot be read.
  explicit ViewerFiles(const std::filesystem::path& folder);

  [[nodiscard]] bool is_empty() const { return files_.empty(); }
  // Finds a file by request path, such as "/assets/index.js"; "/" is "/index.html". Null if
  // missing.
  [[nodiscard]] const ViewerFileContent* find(std::string_view path) const;

 private:
  std::map<std::string, ViewerFileContent, std::less<>> files_;
};

// Returns "../share/multitetra/viewer" relative to this program's folder; empty if it does not
// exist.
[[nodiscard]] std::filesystem::path viewer_folder();

// Returns the files of `folder`; if that is empty, those of viewer_folder(), if it exists. Throws
// like ViewerFiles.
[[nodiscard]] std::shared_ptr<const ViewerFiles> find_viewer(const std::filesystem::path& folder);

}  // namespace multitetra
