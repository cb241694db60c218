#include "server/operations/token_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <limits>
#include <span>
#include <system_error>

#include "common/base/atomic_file.hpp"

namespace multitetra {

namespace fs = std::filesystem;

namespace {

// Handles folders such as /etc/multitetra, which belongs to root and the service's group.
void share_with_group_of_folder(int descriptor, const fs::path& path) {
  struct stat folder {};
  const fs::path name = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (::geteuid() != 0 || ::stat(name.c_str(), &folder) != 0 || folder.st_gid == 0) return;
  if (::fchown(descriptor, static_cast<uid_t>(-1), folder.st_gid) == 0) {
    (void)!::fchmod(descriptor, S_IRUSR | S_IWUSR | S_IRGRP);
  }
}

}  // namespace

TokenFile::TokenFile(const fs::path& path, IfAbsent if_absent)
    : path_(fs::exists(path) ? fs::canonical(path) : path) {
  const bool is_new = if_absent == IfAbsent::kCreate && !fs::exists(path_);
  const int flags =
      O_RDONLY | O_CLOEXEC | O_NONBLOCK | (if_absent == IfAbsent::kCreate ? O_CREAT : 0);
  // Opens again if the previous owner of the lock has replaced the file.
  do {
    opened_ = OpenFile(::open(path_.c_str(), flags, S_IRUSR | S_IWUSR));
    if (!opened_.is_open()) fail("Cannot open");
    if (!opened_.lock(LOCK_EX)) fail("Cannot lock");
  } while (!is_current());
  if (is_new) share_with_group_of_folder(opened_.descriptor(), path_);
}

bool TokenFile::is_current() const {
  struct stat opened {};
  struct stat named {};
  return ::fstat(opened_.descriptor(), &opened) == 0 && ::stat(path_.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

std::string TokenFile::text() const {
  auto content = opened_.content(std::numeric_limits<std::size_t>::max());
  if (!content) fail("Cannot read");
  return *std::move(content);
}

void TokenFile::replace(const std::string& text) {
  AtomicFile file(path_);
  file.write_at(0, std::as_bytes(std::span(text)));
  file.commit(Durability::kMachineStop);
}

void TokenFile::fail(const char* what) const {
  throw std::system_error(errno, std::generic_category(), std::string(what) + " " + path_.string());
}

}  // namespace multitetra
