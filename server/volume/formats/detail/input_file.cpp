#include "server/volume/formats/detail/input_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Without O_NONBLOCK, opening a pipe without a writer would block.
InputFile::InputFile(std::filesystem::path file)
    : file_(std::move(file)), descriptor_(open(file_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  if (descriptor_ < 0) fail(std::strerror(errno));
  struct stat status = {};
  if (fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
    close(descriptor_);
    descriptor_ = -1;
    fail_reading(file_, "it is no regular file", "Check the name");
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

InputFile::InputFile(InputFile&& other) noexcept
    : file_(std::move(other.file_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_) {}

InputFile::~InputFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

std::size_t InputFile::read_some(std::uint64_t offset, std::span<std::byte> into) const {
  std::size_t done = 0;
  while (done < into.size()) {
    const ssize_t got = pread(descriptor_, into.data() + done, into.size() - done,
                              static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(std::strerror(errno));
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

void InputFile::read(std::uint64_t offset, std::span<std::byte> into) const {
  if (read_some(offset, into) == into.size()) return;
  if (offset + into.size() <= size_) fail("it has become shorter since it was opened");
  fail_reading(file_,
               "it ends too early: " + std::to_string(offset + into.size()) +
                   " bytes are promised and " + std::to_string(size_) + " are there",
               "Get a complete copy of the file");
}

std::string InputFile::beginning(std::size_t most) const {
  std::string text(std::min<std::uint64_t>(size_, most), '\0');
  text.resize(read_some(0, std::as_writable_bytes(std::span(text))));
  return text;
}

void InputFile::fail(const std::string& problem) const {
  fail_reading(file_, problem, "Check its permissions and disk");
}

}  // namespace multitetra
