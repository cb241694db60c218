#include "common/base/atomic_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cassert>
#include <cerrno>
#include <cstdio>
#include <ctime>
#include <random>
#include <string_view>
#include <system_error>
#include <utility>

namespace multitetra {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kDigits = 16;
constexpr std::string_view kHiddenEnd = ".tmp";

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

// Returns the common prefix of the names of all hidden files of `path`.
std::string hidden_begin(const fs::path& path) {
  // Stays below the 255 bytes that file systems allow.
  constexpr std::size_t kMaxNameBytes = 200;
  return "." + path.filename().string().substr(0, kMaxNameBytes) + ".";
}

// Returns a name in the same folder, and so on the same file system, where rename() is atomic.
fs::path temporary_path_for(const fs::path& path) {
  std::random_device random;
  std::array<char, kDigits + 1> digits{};
  std::snprintf(digits.data(), digits.size(), "%08x%08x", random(), random());
  return path.parent_path() / (hidden_begin(path) + digits.data() + std::string(kHiddenEnd));
}

bool is_hidden_name(std::string_view name, std::string_view begin) {
  if (name.size() != begin.size() + kDigits + kHiddenEnd.size() || !name.starts_with(begin) ||
      !name.ends_with(kHiddenEnd)) {
    return false;
  }
  const std::string_view digits = name.substr(begin.size(), kDigits);
  return digits.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

// Returns a path to an open file, which also works for a file without a name.
std::string path_of(int descriptor) { return "/proc/self/fd/" + std::to_string(descriptor); }

// Returns a closed file if the file system does not support unnamed files, or cannot link them.
OpenFile open_nameless(const fs::path& folder, unsigned mode) {
  OpenFile file(::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, mode));
  if (::access(path_of(file.descriptor()).c_str(), F_OK) != 0) file.close();
  return file;
}

// A writer keeps its hidden file locked, so that others can detect whether it is alive.
constexpr int kAliveLock = LOCK_EX | LOCK_NB;

// A writer locks its file right after creating it: an old file without a lock is abandoned.
bool is_abandoned(const fs::path& file) {
  constexpr std::time_t kLockedBySeconds = 60;
  const OpenFile opened(::open(file.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  return ::fstat(opened.descriptor(), &status) == 0 && S_ISREG(status.st_mode) &&
         status.st_uid == ::geteuid() && std::time(nullptr) - status.st_mtime > kLockedBySeconds &&
         opened.lock(kAliveLock);
}

// Never fails: skips files that cannot be removed.
void remove_abandoned(const fs::path& path) {
  const std::string begin = hidden_begin(path);
  std::error_code error;
  for (fs::directory_iterator entry(folder_of(path), error), end; !error && entry != end;
       entry.increment(error)) {
    const fs::path& file = entry->path();
    if (is_hidden_name(file.filename().string(), begin) && is_abandoned(file)) {
      ::unlink(file.c_str());
    }
  }
}

}  // namespace

AtomicFile::AtomicFile(fs::path path, TemporaryKind kind, unsigned mode) : path_(std::move(path)) {
  struct stat there {};
  const bool is_there = ::stat(path_.c_str(), &there) == 0;
  if (is_there && !S_ISREG(there.st_mode)) {
    errno = S_ISDIR(there.st_mode) ? EISDIR : EINVAL;
    fail(S_ISDIR(there.st_mode) ? "Cannot replace" : "Not a regular file:");
  }
  if (kind == TemporaryKind::kUnnamed) file_ = open_nameless(folder_of(path_), mode);
  if (!file_.is_open()) create_hidden(mode);
  if (!is_there) return;
  // Best effort: the file stays readable to all users that could read it.
  (void)!::fchown(file_.descriptor(), there.st_uid, there.st_gid);
  (void)!::fchmod(file_.descriptor(), there.st_mode & 0777);
}

void AtomicFile::create_hidden(unsigned mode) {
  hidden_ = temporary_path_for(path_);
  file_ = OpenFile(::open(hidden_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, mode));
  if (!file_.is_open()) {
    hidden_.clear();
    fail("Cannot create");
  }
  // If locking is not supported, no process can mistake the file for an abandoned one.
  (void)file_.lock(kAliveLock);
}

AtomicFile::~AtomicFile() {
  if (!hidden_.empty()) ::unlink(hidden_.c_str());
}

void AtomicFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  assert(file_.is_open());
  if (!file_.write(offset, bytes)) fail("Cannot write");
}

void AtomicFile::read_at(std::uint64_t offset, std::span<std::byte> into) const {
  assert(file_.is_open());
  if (!file_.read(offset, into)) fail("Cannot read");
}

void AtomicFile::commit(Durability durability) {
  assert(file_.is_open());
  const bool durable = durability == Durability::kMachineStop;
  if (durable && ::fsync(file_.descriptor()) != 0) fail("Cannot sync");
  if (hidden_.empty()) link_hidden_name();
  // Some network file systems report a full disk only here.
  if (!file_.close()) fail("Cannot finish");
  if (::rename(hidden_.c_str(), path_.c_str()) != 0) fail("Cannot replace");
  hidden_.clear();
  if (durable) sync_folder();
}

// linkat() cannot replace an existing file, so an unnamed file first gets a hidden name.
void AtomicFile::link_hidden_name() {
  (void)file_.lock(kAliveLock);
  const fs::path hidden = temporary_path_for(path_);
  if (::linkat(AT_FDCWD, path_of(file_.descriptor()).c_str(), AT_FDCWD, hidden.c_str(),
               AT_SYMLINK_FOLLOW) != 0) {
    fail("Cannot name");
  }
  hidden_ = hidden;
}

void AtomicFile::fail(const std::string& what) const {
  const int reason = errno;
  throw std::system_error(reason, std::generic_category(), what + " " + path_.string());
}

// Makes the new name durable. Ignores folders that are writable but not readable, and file systems
// that cannot synchronize folders.
void AtomicFile::sync_folder() const {
  const OpenFile folder(::open(folder_of(path_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder.is_open() || ::fsync(folder.descriptor()) == 0 || errno != EIO) return;
  fail("Cannot sync the folder of");
}

void require_writable(const fs::path& path) {
  const AtomicFile file(path);
  remove_abandoned(path);
}

}  // namespace multitetra
