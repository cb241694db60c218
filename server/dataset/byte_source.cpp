#include "server/dataset/byte_source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

namespace multitetra {
namespace {

namespace fs = std::filesystem;

// Appends the system's reason for the last failed call.
[[noreturn]] void fail_with_reason(const fs::path& file, const std::string& what) {
  const int reason = errno;
  throw DatasetFileError(file, what + ": " + std::generic_category().message(reason) + ".");
}

// Returns the size of an open regular file.
std::uint64_t size_of(const fs::path& file, int descriptor) {
  struct stat status = {};
  if (::fstat(descriptor, &status) != 0) fail_with_reason(file, "it cannot be examined");
  if (!S_ISREG(status.st_mode)) throw DatasetFileError(file, "it is no regular file.");
  return static_cast<std::uint64_t>(status.st_size);
}

}  // namespace

RetainedBytes ByteSource::bytes(std::uint64_t offset, std::size_t size) const {
  auto copy = std::make_shared<std::vector<std::byte>>(size);
  read(offset, *copy);
  const std::span<const std::byte> bytes = *copy;
  return {bytes, std::move(copy)};
}

RetainedBytes MemorySource::bytes(std::uint64_t offset, std::size_t size) const {
  assert(offset <= bytes_.size() && size <= bytes_.size() - offset);
  return bytes_.subspan(static_cast<std::size_t>(offset), size);
}

void MemorySource::read(std::uint64_t offset, std::span<std::byte> into) const {
  assert(offset <= bytes_.size() && into.size() <= bytes_.size() - offset);
  if (!into.empty()) std::memcpy(into.data(), bytes_.data() + offset, into.size());
}

FileSource::FileSource(const fs::path& file)
    // Without O_NONBLOCK, opening a named pipe would block.
    : file_(file), descriptor_(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {
  if (descriptor_ < 0) fail_with_reason(file, "it cannot be opened");
  try {
    size_ = size_of(file, descriptor_);
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

FileSource::~FileSource() { ::close(descriptor_); }

void FileSource::read(std::uint64_t offset, std::span<std::byte> into) const {
  assert(offset <= size_ && into.size() <= size_ - offset);
  while (!into.empty()) {
    const ssize_t count =
        ::pread(descriptor_, into.data(), into.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail_with_reason(file_, "it cannot be read");
    if (count == 0) throw DatasetFileError(file_, "it became shorter while it was read.");
    offset += static_cast<std::uint64_t>(count);
    into = into.subspan(static_cast<std::size_t>(count));
  }
}

}  // namespace multitetra
