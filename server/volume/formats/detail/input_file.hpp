// A file that is read anywhere, in the words of volume files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace multitetra {

class InputFile {
 public:
  // Throws VolumeFileError unless it is a regular file that can be read.
  explicit InputFile(std::filesystem::path file);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  InputFile(InputFile&& other) noexcept;

  [[nodiscard]] const std::filesystem::path& path() const { return file_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }  // When it was opened.

  // The bytes from `offset` on. Throws VolumeFileError when the file ends before they do.
  void read(std::uint64_t offset, std::span<std::byte> into) const;
  // As many of them as there are; returns how many.
  [[nodiscard]] std::size_t read_some(std::uint64_t offset, std::span<std::byte> into) const;
  // The first bytes of the file, at most `most`.
  [[nodiscard]] std::string beginning(std::size_t most) const;

 private:
  [[noreturn]] void fail(const std::string& problem) const;

  std::filesystem::path file_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace multitetra
