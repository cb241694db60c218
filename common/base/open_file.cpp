#include "common/base/open_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

namespace multitetra {

OpenFile::OpenFile(const std::filesystem::path& file)
    : descriptor_(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY)) {}

OpenFile::OpenFile(OpenFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

OpenFile& OpenFile::operator=(OpenFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

OpenFile::~OpenFile() {
  const int reason = errno;
  close();
  errno = reason;
}

bool OpenFile::close() { return descriptor_ < 0 || ::close(std::exchange(descriptor_, -1)) == 0; }

bool OpenFile::lock(int kind) const {
  // A failure to open keeps its reason in errno.
  return is_open() && ::flock(descriptor_, kind) == 0;
}

std::optional<std::uint64_t> OpenFile::regular_size() const {
  struct stat status = {};
  if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  return static_cast<std::uint64_t>(status.st_size);
}

std::optional<std::size_t> OpenFile::read_some(std::uint64_t offset,
                                               std::span<std::byte> into) const {
  std::size_t done = 0;
  while (done < into.size()) {
    const ssize_t count = ::pread(descriptor_, into.data() + done, into.size() - done,
                                  static_cast<off_t>(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return std::nullopt;
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  return done;
}

bool OpenFile::read(std::uint64_t offset, std::span<std::byte> into) const {
  const auto count = read_some(offset, into);
  if (count && *count < into.size()) errno = EIO;
  return count == into.size();
}

std::optional<std::string> OpenFile::content(std::size_t max_bytes) const {
  std::string text;
  if (const auto size = regular_size()) text.reserve(std::min<std::uint64_t>(*size, max_bytes));
  std::array<char, 16 * 1024> piece;  // NOLINT: read into before it is used.
  while (text.size() < max_bytes) {
    const std::size_t size = std::min(piece.size(), max_bytes - text.size());
    const auto count = read_some(text.size(), std::as_writable_bytes(std::span(piece).first(size)));
    if (!count) return std::nullopt;
    text.append(piece.data(), *count);
    if (*count < size) break;
  }
  return text;
}

bool OpenFile::write(std::uint64_t offset, std::span<const std::byte> bytes) const {
  while (!bytes.empty()) {
    const ssize_t count =
        ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return false;
    offset += static_cast<std::uint64_t>(count);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

}  // namespace multitetra
