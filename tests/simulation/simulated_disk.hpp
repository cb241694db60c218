// A store of bytes on a bad disk or network: reads fail, lie and complete in any order, and the
// file is replaced. Its blocks are cached in a folder by the product's DiskCache, on a disk that is
// full from time to time.
#pragma once

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "server/dataset/byte_source.hpp"
#include "server/store/detail/disk_cache.hpp"
#include "server/store/store_error.hpp"
#include "tests/simulation/world.hpp"

namespace multitetra::simulation {

// While it lives, this process can write no further bytes into files.
class FullDisk {
 public:
  explicit FullDisk(bool is_full) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    if (!is_full) return;
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit none = before_;
    none.rlim_cur = 0;
    ::setrlimit(RLIMIT_FSIZE, &none);
  }
  ~FullDisk() { ::setrlimit(RLIMIT_FSIZE, &before_); }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
};

// What happens to the disks of a world, as probabilities per access.
struct Faults {
  double failures = 0;  // A read fails.
  double lies = 0;      // A bit is wrong.
  double full = 0;      // A write fails.
};

class SimulatedDisk : public ByteSource {
 public:
  static constexpr std::uint64_t kBlock = 4096;

  // `name` names the version in the cache; `is_current` becomes false when the file is replaced.
  SimulatedDisk(World& world, const Faults& faults, std::span<const std::byte> bytes,
                std::string name, const bool& is_current, DiskCache* folder)
      : world_(world),
        faults_(faults),
        bytes_(bytes),
        name_(std::move(name)),
        is_current_(is_current),
        folder_(folder) {}

  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  [[nodiscard]] bool is_remote() const override { return true; }
  void check() const override {
    if (!is_current_) throw StoreError("the simulated store", "it was replaced", "Open it again");
  }
  void read(std::uint64_t offset, std::span<std::byte> into) const override {
    for (std::uint64_t at = offset; at < offset + into.size();) {
      const std::vector<std::byte> whole = block(at / kBlock);
      const std::uint64_t skipped = at % kBlock;
      const auto part = std::span(whole).subspan(skipped).first(
          std::min<std::uint64_t>(whole.size() - skipped, offset + into.size() - at));
      std::copy(part.begin(), part.end(), into.begin() + static_cast<std::ptrdiff_t>(at - offset));
      at += part.size();
    }
  }
  // Blocks arrive one by one, in any order.
  void prefetch(std::span<const FileRange> ranges) const override {
    for (const std::uint64_t number : blocks_of(ranges)) {
      world_.after(std::pow(10, world_.uniform(-3, 1)),
                   [arrived = arrived_, number] { arrived->insert(number); });
    }
  }
  [[nodiscard]] std::uint64_t bytes_to_fetch(std::span<const FileRange> ranges) const override {
    std::uint64_t missing = 0;
    for (const std::uint64_t number : blocks_of(ranges)) missing += !arrived_->contains(number);
    return missing * kBlock;
  }
  void invalidate(const FileRange& range) const override {
    for (const std::uint64_t number : blocks_of({&range, 1})) {
      arrived_->erase(number);
      if (folder_) folder_->remove(name_, number);
    }
  }

 private:
  [[nodiscard]] std::set<std::uint64_t> blocks_of(std::span<const FileRange> ranges) const {
    std::set<std::uint64_t> blocks;
    for (const FileRange& range : ranges) {
      for (std::uint64_t at = range.offset / kBlock; at * kBlock < range.offset + range.size;
           ++at) {
        blocks.insert(at);
      }
    }
    return blocks;
  }
  [[nodiscard]] std::vector<std::byte> block(std::uint64_t number) const {
    check();
    if (folder_) {
      if (auto cached = folder_->find(name_, number)) return *std::move(cached);
    }
    if (world_.chance(faults_.failures)) {
      throw StoreError("the simulated store", "it does not answer", "Try again");
    }
    const auto stored = bytes_.subspan(
        number * kBlock, std::min<std::uint64_t>(kBlock, bytes_.size() - number * kBlock));
    std::vector<std::byte> read(stored.begin(), stored.end());
    if (world_.chance(faults_.lies)) {
      read[world_.below(read.size())] ^= static_cast<std::byte>(1 << world_.below(8));
    }
    arrived_->insert(number);
    if (folder_) {
      const FullDisk disk(world_.chance(faults_.full));
      folder_->put(name_, number, read);
    }
    return read;
  }

  World& world_;
  const Faults& faults_;
  const std::span<const std::byte> bytes_;
  const std::string name_;
  const bool& is_current_;
  DiskCache* const folder_;
  // Outlives the source in the events.
  std::shared_ptr<std::set<std::uint64_t>> arrived_ = std::make_shared<std::set<std::uint64_t>>();
};

}  // namespace multitetra::simulation
