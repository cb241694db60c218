#include "server/dataset/byte_source.hpp"

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

}  // namespace

RetainedBytes ByteSource::bytes(std::uint64_t offset, std::size_t size) const {
  auto copy = std::make_shared<std::vector<std::byte>>(size);
  read(offset, *copy);
  const std::span<const std::byte> bytes = *copy;
  return {bytes, std::move(copy)};
}

FileSource::FileSource(const fs::path& file) : file_(file), opened_(file) {
  if (!opened_.is_open()) fail_with_reason(file, "it cannot be opened");
  const auto size = opened_.regular_size();
  if (!size) throw DatasetFileError(file, "it is not a regular file.");
  size_ = *size;
}

void FileSource::read(std::uint64_t offset, std::span<std::byte> into) const {
  assert(offset <= size_ && into.size() <= size_ - offset);
  const auto count = opened_.read_some(offset, into);
  if (!count) fail_with_reason(file_, "it cannot be read");
  if (*count < into.size()) throw DatasetFileError(file_, "it was truncated while it was read.");
}

}  // namespace multitetra
