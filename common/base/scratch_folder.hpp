// A folder for temporary files in the system's temporary folder (TMPDIR), deleted with its content
// at the end. Only its owner may enter it.
#pragma once

#include <filesystem>

namespace multitetra {

class ScratchFolder {
 public:
  // Throws std::system_error with the folder's name and the system's reason.
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace multitetra
