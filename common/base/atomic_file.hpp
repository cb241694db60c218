// A file that appears under its name completely or not at all.
//
//   AtomicFile file("head.mtd");
//   file.write_at(4096, samples);
//   file.write_at(0, head);
//   file.commit(Durability::kMachineStop);
// Bytes are written to an unnamed file on the same disk, which commit() gives its name. Guarantees:
// a reader that opens the name, at any time, gets the old file (or none) or the new one, and an
// open file never changes. Several writers of one name may work at the same time; the last commit
// wins. A killed writer leaves nothing behind, except on file systems without unnamed files (some
// network file systems), where ".NAME.<16 digits>.tmp" remains until require_writable() is called
// for the name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "common/base/open_file.hpp"

namespace multitetra {

// The failures that a committed file survives.
enum class Durability {
  kProcessEnd,   // Survives the end of the writing process. Costs nothing.
  kMachineStop,  // Also survives a crash of the machine. Waits for the disk.
};

// All functions throw std::system_error with the file's name and the system's reason. Not
// thread-safe, except for read_at().
class AtomicFile {
 public:
  // The kind of file that holds the bytes until commit().
  enum class TemporaryKind { kUnnamed, kHidden };

  // The file keeps mode and owner of the file it replaces; new files have `mode`, less the umask.
  // Also throws if the path is a folder or device. kHidden is also the fallback if the file system
  // does not support unnamed files.
  explicit AtomicFile(std::filesystem::path path, TemporaryKind kind = TemporaryKind::kUnnamed,
                      unsigned mode = 0666);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // Accepts any order; bytes never written read as zero. Requires that nothing is committed yet.
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);

  // Reads written bytes. May be called from several threads, also while one writes elsewhere.
  // Requires that nothing is committed yet. Throws if the file ends too early.
  void read_at(std::uint64_t offset, std::span<std::byte> into) const;

  // Gives the file its name. Requires that nothing is committed yet.
  void commit(Durability durability);

 private:
  [[noreturn]] void fail(const std::string& what) const;
  void create_hidden(unsigned mode);
  void link_hidden_name();
  void sync_folder() const;

  std::filesystem::path path_;
  std::filesystem::path hidden_;  // The temporary name; empty if there is none.
  OpenFile file_;                 // Closed once committed.
};

// Throws if writing the file would fail, for programs that write it only after long work. Also
// removes the files of killed writers of this name.
void require_writable(const std::filesystem::path& path);

}  // namespace multitetra
