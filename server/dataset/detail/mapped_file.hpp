// A file as memory that cannot be written; what is looked at is fetched from the disk, and given
// back when others need the memory.
//
// The file must not change meanwhile. Ours never do: a new one takes the name of the old one, which
// stays as long as somebody maps it. When somebody writes into it nevertheless, or cuts it, or the
// disk fails, check() says so: from then on what the memory shows is good for nothing, but can be
// looked at. (A place that the file no longer has would end the program with SIGBUS. It shows zeros
// instead: the first MappedFile of a process installs a handler that sees to that, and leaves all
// other places to the one before it.)
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "server/dataset/byte_source.hpp"

namespace multitetra {

// Safe to use from several threads at once.
class MappedFile : public ByteSource {
 public:
  explicit MappedFile(const std::filesystem::path& path);  // Throws DatasetFileError.
  ~MappedFile() override;
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  // With pread, so that a disk that fails is an error.
  void read(std::uint64_t offset, std::span<std::byte> into) const override {
    file_.read(offset, into);
  }
  [[nodiscard]] KeptBytes bytes(std::uint64_t offset, std::size_t size) const override {
    return bytes_.subspan(static_cast<std::size_t>(offset), size);
  }
  // Throws DatasetFileError when the file is not what it was when it was opened. Costs less than a
  // microsecond.
  void check() const override;

 private:
  struct Guard;  // Of this memory, where the handler finds it.
  struct State {
    std::int64_t size = 0;
    std::int64_t seconds = 0;  // When the file was written last,
    std::int64_t nanoseconds = 0;

    friend bool operator==(const State&, const State&) = default;
  };
  [[nodiscard]] State state() const;

  FileSource file_;
  State opened_;
  std::span<const std::byte> bytes_;
  Guard* guard_ = nullptr;
};

}  // namespace multitetra
