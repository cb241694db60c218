// A file that appears under its name whole or not at all.
//
//   AtomicFile file("head.mtd");
//   file.write_at(4096, samples);
//   file.write_at(0, head);
//   file.commit(Durability::kMachineStop);
// Bytes are written to an unnamed file on the same disk, which gets the name at the end.
// Guaranteed: a reader that opens the name, at any moment, finds the old file (or none) or the new
// one; and a file that is open never changes. Any number of writers of one name may work at the
// same time: the last commit wins. Of a writer that is killed nothing stays, except on file systems
// that know no files without names (some network disks): there ".NAME.<16 digits>.tmp", until
// require_writable is called for the name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace multitetra {

// The failures that a committed file survives.
enum class Durability {
  kProcessEnd,   // The end of the writer. Costs nothing.
  kMachineStop,  // The machine stopping at once. Waits for the disk.
};

// All functions throw std::system_error, which names the file and the system's reason. To be used
// by one thread at a time, but for read_at.
class AtomicFile {
 public:
  // Where the files live until they have their name.
  enum class TemporaryKind { kNameless, kHidden };

  // The file gets mode and owner of the one that was there, and a new one those of any new file.
  // Throws also where something is that no file shall replace: a folder, a device. kHidden is what
  // is done anyway where there are no files without names.
  explicit AtomicFile(std::filesystem::path path, TemporaryKind before = TemporaryKind::kNameless);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // In any order; what is never written reads as zero. Requires that nothing is committed yet.
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);

  // Reads written bytes. From several threads at once, also while one writes elsewhere. Requires
  // that nothing is committed yet, and throws when the file ends before.
  void read_at(std::uint64_t offset, std::span<std::byte> into) const;

  // Gives the file its name. Requires that nothing is committed yet.
  void commit(Durability durability);

 private:
  [[noreturn]] void fail(const std::string& what) const;
  void create_hidden();
  void link_hidden_name();
  void sync_folder() const;

  std::filesystem::path path_;
  std::filesystem::path hidden_;  // Its name until the commit; empty while it has none.
  int descriptor_ = -1;           // Negative once closed.
};

// For programs that write a file after long work: throws, before it, as writing the file would.
// Removes files that killed writers of this name have left.
void require_writable(const std::filesystem::path& path);

}  // namespace multitetra
