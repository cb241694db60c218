// Where the bytes of a prepared dataset come from: a file on this machine, a file behind an
// address, or memory in tests. All readers of datasets go through this interface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>

#include "server/core/spectrum/sample_bricks.hpp"
#include "server/store/remote_files.hpp"

namespace multitetra {

// A prepared file that cannot be written or read, or that is damaged. The text names the file, the
// section, what is wrong, and what to do.
class DatasetFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  DatasetFileError(const std::filesystem::path& file, const std::string& problem)
      : std::runtime_error("'" + file.string() + "': " + problem) {}
};

// Bytes that can be read in any order. Safe to use from several threads at once.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  // Requires offset + into.size() <= size(). Throws what the source throws when it fails.
  virtual void read(std::uint64_t offset, std::span<std::byte> into) const = 0;
  // The same bytes where they lie, as long as the source lives; a copy where they lie nowhere.
  [[nodiscard]] virtual RetainedBytes bytes(std::uint64_t offset, std::size_t size) const;
  // Throws when the source is not what it was when it was opened.
  virtual void check() const {}

  // For remote sources: begins to fetch these ranges. Returns at once and never throws.
  virtual void prefetch(std::span<const FileRange> ranges) const { (void)ranges; }
  // The bytes to fetch from a remote store before these ranges can be read.
  [[nodiscard]] virtual std::uint64_t bytes_to_fetch(std::span<const FileRange> ranges) const {
    (void)ranges;
    return 0;
  }
  // For bytes that turned out to be damaged: the next read of them starts over.
  virtual void forget(const FileRange& range) const { (void)range; }
  [[nodiscard]] virtual bool is_far() const { return false; }
};

// Bytes in memory, which must outlive the source.
class MemorySource : public ByteSource {
 public:
  explicit MemorySource(std::span<const std::byte> bytes) : bytes_(bytes) {}
  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  void read(std::uint64_t offset, std::span<std::byte> into) const override;
  [[nodiscard]] RetainedBytes bytes(std::uint64_t offset, std::size_t size) const override;

 private:
  std::span<const std::byte> bytes_;
};

// A file behind an address. Functions throw StoreError.
class RemoteSource : public ByteSource {
 public:
  explicit RemoteSource(std::shared_ptr<const RemoteFile> file) : file_(std::move(file)) {}
  [[nodiscard]] std::uint64_t size() const override { return file_->size(); }
  void read(std::uint64_t offset, std::span<std::byte> into) const override {
    file_->read(offset, into);
  }
  void prefetch(std::span<const FileRange> ranges) const override { file_->prefetch(ranges); }
  [[nodiscard]] std::uint64_t bytes_to_fetch(std::span<const FileRange> ranges) const override {
    return file_->missing_bytes(ranges);
  }
  void forget(const FileRange& range) const override { file_->forget(range); }
  [[nodiscard]] bool is_far() const override { return true; }

 private:
  std::shared_ptr<const RemoteFile> file_;
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
