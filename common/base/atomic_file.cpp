#include "common/base/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cassert>
#include <cerrno>
#include <cstdio>
#include <random>
#include <string_view>
#include <system_error>
#include <utility>

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// A name in the same folder, and so on the same disk: only there a file takes a name in one step.
fs::path temporary_beside(const fs::path& path) {
  constexpr std::size_t kMaxNameBytes = 200;  // Of the 255 that file systems allow.
  std::random_device random;
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%08x%08x", random(), random());
  return path.parent_path() /
         ("." + path.filename().string().substr(0, kMaxNameBytes) + "." + digits.data() + ".tmp");
}

}  // namespace

AtomicFile::AtomicFile(fs::path path)
    : path_(std::move(path)), temporary_(temporary_beside(path_)) {
  descriptor_ = ::open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail("Cannot create");
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!committed_) ::unlink(temporary_.c_str());
}

void AtomicFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  assert(descriptor_ >= 0);
  while (!bytes.empty()) {
    const ssize_t count =
        ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail("Cannot write");
    offset += static_cast<std::uint64_t>(count);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

void AtomicFile::read_at(std::uint64_t offset, std::span<std::byte> into) const {
  assert(descriptor_ >= 0);
  while (!into.empty()) {
    const ssize_t count =
        ::pread(descriptor_, into.data(), into.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) errno = EIO;  // Somebody cut it.
    if (count <= 0) fail("Cannot read");
    offset += static_cast<std::uint64_t>(count);
    into = into.subspan(static_cast<std::size_t>(count));
  }
}

void AtomicFile::commit(Durability durability) {
  assert(descriptor_ >= 0);
  const bool durable = durability == Durability::kMachineStop;
  if (durable && ::fsync(descriptor_) != 0) fail("Cannot bring to the disk:");
  // Some network disks report only here that they are full.
  if (::close(std::exchange(descriptor_, -1)) != 0) fail("Cannot finish");
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail("Cannot replace");
  committed_ = true;
  if (durable) bring_folder_to_disk();
}

void AtomicFile::fail(const std::string& what) const {
  const int reason = errno;
  throw std::system_error(reason, std::generic_category(), what + " " + path_.string());
}

// The name itself. A folder that may be written but not read, and file systems that know no such
// thing, keep the name without this as well as they can.
void AtomicFile::bring_folder_to_disk() const {
  const fs::path folder = path_.has_parent_path() ? path_.parent_path() : fs::path(".");
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  const bool failed = ::fsync(descriptor) != 0 && errno == EIO;
  ::close(descriptor);
  if (!failed) return;
  errno = EIO;
  fail("Cannot bring the name to the disk:");
}

}  // namespace multitetra
