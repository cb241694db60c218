// Temporary bytes in an unnamed file, or in memory.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <span>
#include <vector>

#include "common/base/scratch.hpp"

namespace multitetra {

// A file that has no name, so that nothing is left of it when its owner ends, in whatever way. All
// functions throw std::system_error when the disk fails.
class ScratchFile : public Scratch {
 public:
  // On the disk of `folder`.
  explicit ScratchFile(const std::filesystem::path& folder);
  ~ScratchFile() override;
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  [[nodiscard]] std::uint64_t put(std::span<const std::byte> bytes) override;
  void get(std::uint64_t offset, std::span<std::byte> into) const override;
  // In any order. Not together with put().
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);

 private:
  int descriptor_ = -1;
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

}  // namespace multitetra
