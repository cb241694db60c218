// A file that appears under its name whole or not at all.
//
//   AtomicFile file("head.mtd");
//   file.write_at(4096, samples);
//   file.write_at(0, head);
//   file.commit(Durability::kMachineStop);
//
// What is written goes to a temporary file beside the name, which takes the name in one step.
// Guaranteed: whoever opens the name, at any moment, finds the old file (or none) or the new one;
// and what somebody holds open never changes under him. Without a commit the temporary file is
// removed; only a writer that is killed leaves one behind, as ".NAME.<16 digits>.tmp". Any number
// of writers of one name may work at the same time: the last commit wins.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace multitetra {

// What a committed file is still there after.
enum class Durability {
  kProcessEnd,   // The end of the writer. Costs nothing.
  kMachineStop,  // The machine stopping at once. Waits for the disk.
};

// All functions throw std::system_error, which names the file and the system's reason. To be used
// by one thread at a time, but for read_at.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  // In any order; what is never written reads as zero. Requires that nothing is committed yet.
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);

  // What was written there. From several threads at once, also while one writes elsewhere. Requires
  // that nothing is committed yet, and throws when the file ends before.
  void read_at(std::uint64_t offset, std::span<std::byte> into) const;

  // Gives the file its name. Requires that nothing is committed yet.
  void commit(Durability durability);

 private:
  [[noreturn]] void fail(const std::string& what) const;
  void bring_folder_to_disk() const;

  std::filesystem::path path_;
  std::filesystem::path temporary_;
  int descriptor_ = -1;  // Negative once closed.
  bool committed_ = false;
};

}  // namespace multitetra
