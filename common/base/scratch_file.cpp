#include "common/base/scratch_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>

namespace multitetra {
namespace {

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

// Falls back to a named file that is unlinked at once if the file system has no unnamed files.
int open_scratch(const std::filesystem::path& folder) {
  const std::filesystem::path place = folder.empty() ? std::filesystem::path(".") : folder;
  const int descriptor = ::open(place.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (descriptor >= 0) return descriptor;
  std::string name = (place / ".multitetra.XXXXXX").string();
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

}  // namespace

ScratchFile::ScratchFile(const std::filesystem::path& folder) : file_(open_scratch(folder)) {
  if (!file_.is_open()) fail("Cannot create a temporary file");
}

std::uint64_t ScratchFile::put(std::span<const std::byte> bytes) {
  const std::uint64_t offset = size_.fetch_add(bytes.size());
  write_at(offset, bytes);
  return offset;
}

void ScratchFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  if (!file_.write(offset, bytes)) fail("Cannot write to a temporary file");
}

void ScratchFile::get(std::uint64_t offset, std::span<std::byte> into) const {
  if (!file_.read(offset, into)) fail("Cannot read from a temporary file");
}

std::uint64_t ScratchMemory::put(std::span<const std::byte> bytes) {
  const std::lock_guard lock(mutex_);
  const std::uint64_t offset = bytes_.size();
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  return offset;
}

void ScratchMemory::get(std::uint64_t offset, std::span<std::byte> into) const {
  const std::lock_guard lock(mutex_);
  assert(offset + into.size() <= bytes_.size());
  std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), into.size(), into.begin());
}

ScratchFolder::ScratchFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "multitetra.XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) {
    throw std::system_error(errno, std::generic_category(), "Cannot create " + name);
  }
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace multitetra
