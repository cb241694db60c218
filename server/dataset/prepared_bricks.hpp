// The bricks of a prepared dataset, verified when they are first looked at.
//
// A brick's bytes are only handed out when they have their checksum. That is found out at the first
// look and remembered, so that later looks cost next to nothing. Safe to use from several threads:
// when two of them look first, both verify.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "server/core/spectrum/sample_bricks.hpp"
#include "server/dataset/mapped_file.hpp"
#include "server/dataset/prepared_format.hpp"

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

// Reads from memory that somebody else keeps, which must not change; where it is a mapped file, one
// that did is noticed.
class PreparedBricks : public BrickSource {
 public:
  // Requires index < size(). Throws DatasetFileError, with the file, the section, the brick and
  // what to do, when the brick is damaged.
  [[nodiscard]] KeptBytes brick(std::size_t index) const final;

  [[nodiscard]] std::size_t size() const { return size_; }
  // How often brick() was called so far.
  [[nodiscard]] std::uint64_t reads() const { return reads_.load(std::memory_order_relaxed); }

 protected:
  // `file` is for errors. Requires the section to lie in `bytes`, those of the whole file, which
  // lives as long as this. `mapped` is where they come from, if anywhere.
  PreparedBricks(std::filesystem::path file, std::span<const std::byte> bytes,
                 const Section& section, std::size_t size, std::optional<SampleType> type,
                 const MappedFile* mapped);

 private:
  [[nodiscard]] virtual BrickPlace place(std::size_t index) const = 0;

  const std::filesystem::path file_;
  const std::string section_;
  const std::span<const std::byte> bytes_;  // Of the section.
  const std::size_t size_;
  const std::optional<SampleType> type_;
  const MappedFile* const mapped_;
  // Below, what threads write: away from what they only read.
  alignas(64) mutable std::atomic<std::uint64_t> reads_ = 0;
  mutable ConcurrentSet verified_;
};

// The section "samples". A brick begins at a multiple of the size of its samples.
class SampleBricks final : public PreparedBricks {
 public:
  SampleBricks(std::filesystem::path file, std::span<const std::byte> bytes,
               std::shared_ptr<const PreparedStructure> structure,
               const MappedFile* mapped = nullptr);

 private:
  [[nodiscard]] BrickPlace place(std::size_t index) const override;

  const std::shared_ptr<const PreparedStructure> structure_;
  const BrickLayout layout_;
};

// The section "spectrum". A brick begins anywhere; many are empty.
class SpectrumBricks final : public PreparedBricks {
 public:
  SpectrumBricks(std::filesystem::path file, std::span<const std::byte> bytes,
                 std::shared_ptr<const PreparedStructure> structure,
                 const MappedFile* mapped = nullptr);

 private:
  [[nodiscard]] BrickPlace place(std::size_t index) const override;

  const std::shared_ptr<const PreparedStructure> structure_;
};

}  // namespace multitetra
