// The bricks of a prepared dataset, unpacked and verified when they are looked at.
//
// A brick's bytes are only handed out when they have their checksum. Raw bricks of a mapped file
// are handed out in place, verified at the first look; others are unpacked into a cache that all
// datasets share. Safe to use from several threads: when two of them look first, both unpack.
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

// A set of small numbers that threads may add to at the same time.
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

// Parameters that all bricks of a dataset share. Bytes that tests keep in memory are a source, too.
struct BrickFile {
  std::string place;  // For errors.
  std::shared_ptr<const ByteSource> source = nullptr;
  std::shared_ptr<const PreparedStructure> structure = nullptr;
  std::shared_ptr<MemoryCache> cache = nullptr;
};

class PreparedBricks : public BrickSource {
 public:
  // Requires index < size(). Throws DatasetFileError, with the file, the section, the brick and
  // what to do, when the brick is damaged, and what the source throws.
  [[nodiscard]] RetainedBytes brick(std::size_t index) const final;
  void prefetch(std::span<const std::size_t> bricks) const final;
  [[nodiscard]] std::uint64_t bytes_to_fetch(std::span<const std::size_t> bricks) const final;
  [[nodiscard]] bool is_far() const final { return file_.source->is_far(); }

  [[nodiscard]] std::size_t size() const { return size_; }
  // The number of calls of brick() so far.
  [[nodiscard]] std::uint64_t reads() const { return reads_.load(std::memory_order_relaxed); }

 protected:
  // `type` is that of samples, none in the spectrum.
  PreparedBricks(BrickFile file, const char* section, std::size_t size,
                 std::optional<SampleType> type);

  [[nodiscard]] const BrickFile& file() const { return file_; }

 private:
  // By number of the brick. May read it, and then throws what that throws.
  [[nodiscard]] virtual std::span<const BrickPlace> index() const = 0;
  // When it is unpacked; not asked for in the spectrum.
  [[nodiscard]] virtual std::size_t bytes_of(std::size_t index) const = 0;
  [[nodiscard]] RetainedBytes in_place(std::size_t index, const BrickPlace& place) const;
  [[nodiscard]] CachedBytes unpacked(std::size_t index, const BrickPlace& place) const;
  [[nodiscard]] RetainedBytes constant(std::size_t index, const BrickPlace& place) const;
  [[nodiscard]] FileRange range_of(const BrickPlace& place) const {
    return {.offset = section_.offset + place.offset, .size = place.size()};
  }
  [[nodiscard]] std::vector<FileRange> ranges_of(std::span<const std::size_t> bricks) const;
  void look_ahead(const BrickPlace& place) const;

  const BrickFile file_;
  const Section section_;
  const std::size_t size_;
  const std::optional<SampleType> type_;
  const MemoryCache::Owner owner_;
  // Below, what threads write: away from what they only read.
  alignas(64) mutable std::atomic<std::uint64_t> reads_ = 0;
  // Which of the bricks in place were verified.
  mutable ConcurrentSet verified_;
};

// The section "samples". Its index is read at the first look, of a far file.
class SampleBricks final : public PreparedBricks {
 public:
  explicit SampleBricks(const BrickFile& file);

  // Reads the index. Throws DatasetFileError when it is damaged, and what the source throws.
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
