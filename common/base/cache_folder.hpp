// A private folder of cached files in which a mark, never a place, says what may be deleted.
//
//   /var/cache/multitetra/CACHEDIR.TAG            the mark; backup programs know it, too
//   /var/cache/multitetra/blocks/                 one kind of cache
//   /var/cache/multitetra/blocks/9f1c.../         an entry ...
//   /var/cache/multitetra/blocks/9f1c.../CACHEDIR.TAG    ... and its mark
//
//   CacheFolder cache("/var/cache/multitetra", "blocks");
//   const std::filesystem::path entry = cache.create("9f1c...");
//
// The mark is that of https://bford.info/cachedir with the name of this program.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace multitetra {

// The permissions of files in entries.
inline constexpr unsigned kCachedFileMode = 0600;

class CacheFolderError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Several processes may share a folder.
class CacheFolder {
 public:
  // Creates `folder` and in it the folder of this kind, both with permissions 700 and the mark.
  // Throws CacheFolderError, with the remedy, if the folder exists and holds anything but has no
  // mark, belongs to another user, or can be written by others; and if the disk fails.
  CacheFolder(const std::filesystem::path& folder, std::string_view kind);

  // Returns the folder of an entry; creates and marks it if necessary. Requires a file name. Throws
  // std::filesystem::filesystem_error.
  [[nodiscard]] std::filesystem::path create(const std::string& name) const;

  // Returns the path of an entry that may not exist.
  [[nodiscard]] std::filesystem::path path_of(const std::string& name) const {
    return folder_ / name;
  }

  // Returns the folders that carry the mark: only these may be deleted, or files in them.
  [[nodiscard]] std::vector<std::filesystem::path> entries() const;

 private:
  std::filesystem::path folder_;  // With the kind.
};

}  // namespace multitetra
