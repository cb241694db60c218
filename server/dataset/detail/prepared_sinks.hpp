// The destinations to which preparation writes a volume.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "common/dataset/dataset_info.hpp"
#include "server/core/spectrum/sample_bricks.hpp"
#include "server/core/spectrum/spectrum_inputs.hpp"
#include "server/dataset/dataset_writer.hpp"

namespace multitetra {

class PreparedSink {
 public:
  virtual ~PreparedSink() = default;
  // Appends the next bricks, in order.
  virtual void add_samples(std::span<const std::byte> bytes) = 0;
  // Reads bricks that were added. May be called from several threads.
  virtual void read_samples(std::size_t first, std::span<std::byte> bytes) const = 0;
  [[nodiscard]] virtual std::unique_ptr<Scratch> new_scratch() const = 0;
  virtual void add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes) = 0;
};

class FileSink final : public PreparedSink {
 public:
  FileSink(const std::filesystem::path& path, const DatasetInfo& info);
  void add_samples(std::span<const std::byte> bytes) override { writer_.add_samples(bytes); }
  void read_samples(std::size_t first, std::span<std::byte> bytes) const override {
    writer_.read_samples(first, bytes);
  }
  // Returns scratch space on the disk of the file.
  [[nodiscard]] std::unique_ptr<Scratch> new_scratch() const override;
  void add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes) override {
    writer_.add_spectrum_brick(index, bytes);
  }
  [[nodiscard]] DatasetWriter& writer() { return writer_; }

 private:
  DatasetWriter writer_;
  std::filesystem::path folder_;
};

// Keeps the samples in memory, for a dataset without errors.
class MemorySink final : public PreparedSink, public BrickSource {
 public:
  explicit MemorySink(const DatasetInfo& info);
  void add_samples(std::span<const std::byte> bytes) override;
  void read_samples(std::size_t first, std::span<std::byte> bytes) const override;
  [[nodiscard]] std::unique_ptr<Scratch> new_scratch() const override;
  // Must not be called.
  void add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes) override;
  [[nodiscard]] RetainedBytes brick(std::size_t index) const override;

 private:
  [[nodiscard]] std::size_t offset_of(std::size_t brick) const;

  BrickLayout layout_;
  std::size_t sample_bytes_;
  std::vector<std::byte> samples_;
};

}  // namespace multitetra
