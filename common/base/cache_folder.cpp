#include "common/base/cache_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <span>
#include <system_error>

#include "common/base/atomic_file.hpp"
#include "common/base/open_file.hpp"

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMarkFile = "CACHEDIR.TAG";
constexpr std::string_view kMark =
    "Signature: 8a477f597d28d172789f06886806bc55\n"
    "# A cache of Multi-Tetra streaming, which may delete what is in this folder.\n"
    "# See https://bford.info/cachedir\n";

[[noreturn]] void refuse(const fs::path& folder, const std::string& reason) {
  throw CacheFolderError("The cache folder '" + folder.string() + "' is not used: " + reason);
}

bool has_mark(const fs::path& folder) {
  const OpenFile file(
      ::open((folder / kMarkFile).c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  return file.regular_size() == kMark.size() && file.content(kMark.size()) == kMark;
}

void write_mark(const fs::path& folder) {
  AtomicFile file(folder / kMarkFile, AtomicFile::TemporaryKind::kUnnamed, kCachedFileMode);
  file.write_at(0, std::as_bytes(std::span(kMark)));
  file.commit(Durability::kProcessEnd);
}

void create_private(const fs::path& folder) {
  if (::mkdir(folder.c_str(), 0700) == 0 || errno == EEXIST) return;
  throw fs::filesystem_error("cannot create", folder, {errno, std::generic_category()});
}

// Creates the folder, or takes an empty or marked one of this user.
void claim(const fs::path& folder, int follow) {
  create_private(folder);
  const OpenFile opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | follow));
  struct stat status {};
  if (!opened.is_open() || ::fstat(opened.descriptor(), &status) != 0) {
    refuse(folder, std::generic_category().message(errno) + ".");
  }
  if (status.st_uid != ::geteuid()) {
    refuse(folder, "it belongs to another user. Give a folder of this one.");
  }
  if ((status.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    refuse(folder, "other users may write into it. Run chmod go-w on it, or give another folder.");
  }
  // Another process may be about to write the mark.
  (void)opened.lock(LOCK_EX);
  if (has_mark(folder)) return;
  if (!fs::is_empty(folder)) {
    refuse(folder, "it holds files that are not of this cache (there is no " +
                       std::string(kMarkFile) + " of this program). Give a new or empty folder.");
  }
  write_mark(folder);
}

}  // namespace

CacheFolder::CacheFolder(const fs::path& folder, std::string_view kind) : folder_(folder / kind) {
  try {
    const fs::path above = fs::absolute(folder / "").parent_path().parent_path();
    fs::create_directories(above);
    claim(folder, 0);
    claim(folder_, O_NOFOLLOW);
  } catch (const std::system_error& error) {
    refuse(folder, std::string(error.what()) + ".");
  }
}

fs::path CacheFolder::create(const std::string& name) const {
  const fs::path entry = folder_ / name;
  create_private(entry);
  if (!has_mark(entry)) write_mark(entry);
  return entry;
}

std::vector<fs::path> CacheFolder::entries() const {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator at(folder_, error), end; !error && at != end; at.increment(error)) {
    std::error_code gone;  // Other processes may remove entries meanwhile.
    if (!at->is_symlink(gone) && at->is_directory(gone) && has_mark(at->path())) {
      found.push_back(at->path());
    }
  }
  return found;
}

}  // namespace multitetra
