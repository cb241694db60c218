#include "server/volume/formats/detail/input_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

InputFile::InputFile(std::filesystem::path file) : file_(std::move(file)), opened_(file_) {
  if (!opened_.is_open()) fail(std::strerror(errno));
  const auto size = opened_.regular_size();
  if (!size) fail_reading(file_, "it is not a regular file", "Check the name");
  size_ = *size;
}

std::size_t InputFile::read_some(std::uint64_t offset, std::span<std::byte> into) const {
  const auto count = opened_.read_some(offset, into);
  if (!count) fail(std::strerror(errno));
  return *count;
}

void InputFile::read(std::uint64_t offset, std::span<std::byte> into) const {
  if (read_some(offset, into) == into.size()) return;
  if (offset + into.size() <= size_) fail("it was truncated after it was opened");
  fail_incomplete(file_, "it ends too early: " + std::to_string(offset + into.size()) +
                             " bytes are expected, but it has " + std::to_string(size_) + " bytes");
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
