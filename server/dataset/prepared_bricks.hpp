// The bricks of a prepared dataset, verified and unpacked on access.
//
// A brick's bytes are returned only if their checksum matches. Raw bricks of a mapped file are
// returned in place and verified on first access; others are unpacked into a cache that all
// datasets share. Thread-safe; concurrent accesses to a brick may both unpack it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "server/core/spectrum/sample_bricks.hpp"
#include "server/dataset/prepared_format.hpp"
#include "server/store/memory_cache.hpp"

namespace multitetra {

// A set of integers from 0 to `end` - 1; several threads may add to it at once.
class ConcurrentSet {
 public:
  explicit ConcurrentSet(std::size_t end) : words_((end + kWordBits - 1) / kWordBits) {}
  // Requires number < end.
  [[nodiscard]] bool contains(std::size_t number) const {
    return (words_[number / kWordBits].load(std::memory_order_relaxed) & bit(number)) != 0;
  }
  void add(std::size_t number) {
    words_[number / kWordBits].fetch_or(bit(number), std::memory_order_relaxed);
  }

 private:
  static constexpr std::size_t kWordBits = 64;
  static std::uint64_t bit(std::size_t number) { return std::uint64_t{1} << number % kWordBits; }

  std::vector<std::atomic<std::uint64_t>> words_;
};

// State that all bricks of a dataset share.
struct BrickFile {
  std::string place;  // Named in error texts.
  std::shared_ptr<const ByteSource> source = nullptr;
  std::shared_ptr<const PreparedStructure> structure = nullptr;
  std::shared_ptr<MemoryCache> cache = nullptr;
};

class PreparedBricks : public BrickSource {
 public:
  // Requires index < size(). Throws the source's exceptions and, if the brick is damaged, a
  // DatasetFileError that names the file, the section, the brick and the remedy.
  [[nodiscard]] RetainedBytes brick(std::size_t index) const final;
  // Returns a brick as it is stored. Requires and throws the same.
  [[nodiscard]] PackedBrick packed(std::size_t index) const;
  void prefetch(std::span<const std::size_t> bricks) const final;
  [[nodiscard]] std::uint64_t bytes_to_fetch(std::span<const std::size_t> bricks) const final;
  [[nodiscard]] bool is_remote() const final { return file_.source->is_remote(); }

  [[nodiscard]] std::size_t size() const { return size_; }
  // Returns the number of calls of brick() so far.
  [[nodiscard]] std::uint64_t reads() const { return reads_.load(std::memory_order_relaxed); }

 protected:
  // `type` is the type of the samples; absent for the spectrum.
  PreparedBricks(BrickFile file, const char* section, std::size_t size,
                 std::optional<SampleType> type);

  [[nodiscard]] const BrickFile& file() const { return file_; }

 private:
  // Indexed by brick. May read the index and throws if that fails.
  [[nodiscard]] virtual std::span<const BrickPlace> index() const = 0;
  // Returns the unpacked size of a brick; not called for the spectrum.
  [[nodiscard]] virtual std::size_t bytes_of(std::size_t index) const = 0;
  [[nodiscard]] RetainedBytes in_place(std::size_t index, const BrickPlace& place) const;
  [[nodiscard]] CachedBytes unpacked(std::size_t index, const BrickPlace& place) const;
  [[nodiscard]] RetainedBytes constant(std::size_t index, const BrickPlace& place) const;
  [[nodiscard]] FileRange range_of(const BrickPlace& place) const {
    return {.offset = section_.offset + place.offset, .size = place.size()};
  }
  [[nodiscard]] std::vector<FileRange> ranges_of(std::span<const std::size_t> bricks) const;
  // Prefetches the bricks that follow an absent brick of a remote spectrum.
  void prefetch_following(const BrickPlace& place) const;

  const BrickFile file_;
  const Section section_;
  const std::size_t size_;
  const std::optional<SampleType> type_;
  const MemoryCache::Owner owner_;
  // Written by all threads: on a cache line apart from the read-only members.
  alignas(64) mutable std::atomic<std::uint64_t> reads_ = 0;
  // The bricks in place that were verified.
  mutable ConcurrentSet verified_;
};

// The section "samples". The index of a remote file is read on first access.
class SampleBricks final : public PreparedBricks {
 public:
  explicit SampleBricks(const BrickFile& file);

  // Reads the index. Throws DatasetFileError if it is damaged, and the source's exceptions.
  [[nodiscard]] std::span<const BrickPlace> index() const override;

 private:
  [[nodiscard]] std::size_t bytes_of(std::size_t index) const override;

  const BrickLayout layout_;
  mutable std::once_flag is_read_;
  mutable std::vector<BrickPlace> index_;
};

// The section "spectrum". Many bricks are empty.
class SpectrumBricks final : public PreparedBricks {
 public:
  explicit SpectrumBricks(const BrickFile& file);

 private:
  [[nodiscard]] std::span<const BrickPlace> index() const override {
    return file().structure->spectrum_index;
  }
  [[nodiscard]] std::size_t bytes_of(std::size_t) const override { return 0; }
};

}  // namespace multitetra
