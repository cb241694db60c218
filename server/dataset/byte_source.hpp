// Where the bytes of a prepared dataset come from: a file, or memory in tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>

namespace multitetra {

// A prepared file that cannot be written or read, or that is damaged. The text names the file, the
// section, what is wrong, and what to do.
class DatasetFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  DatasetFileError(const std::filesystem::path& file, const std::string& problem)
      : std::runtime_error("'" + file.string() + "': " + problem) {}
};

// Bytes that can be read in any order.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  // Requires offset + into.size() <= size(). Throws what the source throws when it fails.
  virtual void read(std::uint64_t offset, std::span<std::byte> into) const = 0;
};

// Bytes that somebody else keeps in memory.
class MemorySource : public ByteSource {
 public:
  explicit MemorySource(std::span<const std::byte> bytes) : bytes_(bytes) {}
  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  void read(std::uint64_t offset, std::span<std::byte> into) const override;

 private:
  std::span<const std::byte> bytes_;
};

// An open file. Its size is that at the opening: when the file becomes shorter, read() throws. All
// functions throw DatasetFileError.
class FileSource : public ByteSource {
 public:
  explicit FileSource(const std::filesystem::path& file);
  ~FileSource() override;
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  [[nodiscard]] std::uint64_t size() const override { return size_; }
  void read(std::uint64_t offset, std::span<std::byte> into) const override;

 private:
  friend class MappedFile;  // mapped_file.hpp

  std::filesystem::path file_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace multitetra
