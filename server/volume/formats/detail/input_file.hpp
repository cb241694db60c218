// Random access to a file; reports errors as VolumeFileError.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "common/base/open_file.hpp"

namespace multitetra {

class InputFile {
 public:
  // Throws VolumeFileError unless it is a readable regular file.
  explicit InputFile(std::filesystem::path file);

  [[nodiscard]] const std::filesystem::path& path() const { return file_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }  // Size at opening.

  // Reads bytes from `offset`. Throws VolumeFileError if the file ends before them.
  void read(std::uint64_t offset, std::span<std::byte> into) const;
  // Reads as many bytes as there are; returns their number.
  [[nodiscard]] std::size_t read_some(std::uint64_t offset, std::span<std::byte> into) const;
  // Returns the first bytes of the file, at most `most`.
  [[nodiscard]] std::string beginning(std::size_t most) const;

 private:
  [[noreturn]] void fail(const std::string& problem) const;

  std::filesystem::path file_;
  OpenFile opened_;
  std::uint64_t size_ = 0;
};

}  // namespace multitetra
