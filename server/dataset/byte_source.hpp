// The bytes of a prepared dataset: a local file, a remote file, or memory in tests. All readers of
// datasets use this interface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>

#include "common/base/open_file.hpp"
#include "server/core/spectrum/sample_bricks.hpp"
#include "server/store/remote_files.hpp"

namespace multitetra {

// A prepared file cannot be read or written, or is damaged. The text names the file, the section,
// the problem and the remedy.
class DatasetFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  DatasetFileError(const std::filesystem::path& file, const std::string& problem)
      : std::runtime_error("'" + file.string() + "': " + problem) {}
};

// Random access to bytes. Safe to use from several threads at once.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  // Requires offset + into.size() <= size(). Throws the source's own exceptions on failure.
  virtual void read(std::uint64_t offset, std::span<std::byte> into) const = 0;
  // Returns the bytes without copying if the source holds them in memory (valid while the source
  // lives), else a copy.
  [[nodiscard]] virtual RetainedBytes bytes(std::uint64_t offset, std::size_t size) const;
  // Throws if the source has changed since it was opened.
  virtual void check() const {}

  // Starts fetching these ranges from a remote source. Returns at once and never throws.
  virtual void prefetch(std::span<const FileRange> ranges) const { (void)ranges; }
  // Returns the number of bytes that reading these ranges would fetch from a remote store.
  [[nodiscard]] virtual std::uint64_t bytes_to_fetch(std::span<const FileRange> ranges) const {
    (void)ranges;
    return 0;
  }
  // Drops cached bytes that turned out to be damaged; the next read fetches them again.
  virtual void invalidate(const FileRange& range) const { (void)range; }
  [[nodiscard]] virtual bool is_remote() const { return false; }
};

// A remote file. Functions throw StoreError.
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
  void invalidate(const FileRange& range) const override { file_->invalidate(range); }
  [[nodiscard]] bool is_remote() const override { return true; }

 private:
  std::shared_ptr<const RemoteFile> file_;
};

// An open local file. Its size is fixed when it is opened; read() throws if the file has become
// shorter. All functions throw DatasetFileError.
class FileSource : public ByteSource {
 public:
  explicit FileSource(const std::filesystem::path& file);

  [[nodiscard]] std::uint64_t size() const override { return size_; }
  void read(std::uint64_t offset, std::span<std::byte> into) const override;

 private:
  friend class MappedFile;

  std::filesystem::path file_;
  OpenFile opened_;
  std::uint64_t size_ = 0;
};

}  // namespace multitetra
