// Destinations of a volume that is being prepared: a file, or memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "common/request/dataset_info.hpp"
#include "server/core/spectrum/sample_bricks.hpp"
#include "server/core/spectrum/spectrum_inputs.hpp"
#include "server/dataset/dataset_writer.hpp"

namespace multitetra {

class PreparedSink {
 public:
  virtual ~PreparedSink() = default;
  // The next bricks, in order.
  virtual void add_samples(std::span<const std::byte> bytes) = 0;
  // Reads bricks that were added. From several threads at once.
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
  // On the disk of the file.
  [[nodiscard]] std::unique_ptr<Scratch> new_scratch() const override;
  void add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes) override {
    writer_.add_spectrum_brick(index, bytes);
  }
  [[nodiscard]] DatasetWriter& writer() { return writer_; }

 private:
  DatasetWriter writer_;
  std::filesystem::path folder_;
};

class MemorySink final : public PreparedSink {
 public:
  explicit MemorySink(const DatasetInfo& info);
  void add_samples(std::span<const std::byte> bytes) override;
  void read_samples(std::size_t first, std::span<std::byte> bytes) const override;
  [[nodiscard]] std::unique_ptr<Scratch> new_scratch() const override;
  void add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes) override;
  [[nodiscard]] std::shared_ptr<const BrickSource> samples() const;
  [[nodiscard]] std::shared_ptr<const BrickSource> spectrum() const;

 private:
  class Bricks;

  std::size_t sample_bytes_;
  BrickLayout layout_;
  std::shared_ptr<Bricks> samples_;
  std::shared_ptr<Bricks> spectrum_;
  std::size_t next_ = 0;
};

}  // namespace multitetra
