// A read-only memory mapping of a file. Pages are read from the disk on access and evicted under
// memory pressure.
//
// The file must not change while it is mapped. Our programs replace files by renaming, which leaves
// the mapped one intact. If the file is overwritten or truncated anyway, or the disk fails, check()
// reports it: from then on the memory is readable but its content is undefined. (Reading beyond the
// end of a truncated file would end the program with SIGBUS. The first MappedFile of a process
// installs a handler that maps zeros there instead, and passes faults at other addresses to the
// previous handler.)
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
  // Uses pread(), so that a failing disk is reported as an error.
  void read(std::uint64_t offset, std::span<std::byte> into) const override {
    file_.read(offset, into);
  }
  [[nodiscard]] RetainedBytes bytes(std::uint64_t offset, std::size_t size) const override {
    return bytes_.subspan(static_cast<std::size_t>(offset), size);
  }
  // Throws DatasetFileError if the file has changed since it was opened. Takes under a microsecond.
  void check() const override;

 private:
  // Registers this memory with the signal handler.
  struct Guard;
  struct State {
    std::int64_t size = 0;
    std::int64_t seconds = 0;  // Time of the last modification.
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
