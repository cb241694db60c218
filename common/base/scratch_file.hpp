// Temporary storage in an unnamed file, in a folder, or in memory.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <span>
#include <vector>

#include "common/base/open_file.hpp"
#include "common/base/scratch.hpp"

namespace multitetra {

// An unnamed file, which disappears when its owner ends in any way. All functions throw
// std::system_error on disk errors.
class ScratchFile : public Scratch {
 public:
  // Creates the file on the disk of `folder`.
  explicit ScratchFile(const std::filesystem::path& folder);

  [[nodiscard]] std::uint64_t put(std::span<const std::byte> bytes) override;
  void get(std::uint64_t offset, std::span<std::byte> into) const override;
  // Accepts any order. Do not combine with put().
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);

 private:
  OpenFile file_;
  std::atomic<std::uint64_t> size_ = 0;
};

class ScratchMemory : public Scratch {
 public:
  [[nodiscard]] std::uint64_t put(std::span<const std::byte> bytes) override;
  void get(std::uint64_t offset, std::span<std::byte> into) const override;

 private:
  mutable std::mutex mutex_;  // Guards `bytes_`.
  std::vector<std::byte> bytes_;
};

// A folder in the system's temporary folder (TMPDIR), which only its owner may enter, deleted with
// its content at the end.
class ScratchFolder {
 public:
  // Throws std::system_error with the folder's name and the system's reason.
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace multitetra
