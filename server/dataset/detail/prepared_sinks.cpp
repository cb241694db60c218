#include "server/dataset/detail/prepared_sinks.hpp"

#include <algorithm>

#include "common/base/scratch_file.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {

// ---- a file

FileSink::FileSink(const std::filesystem::path& path, const DatasetInfo& info)
    : writer_(
          path,
          {.dims = info.dims, .type = info.type, .spectrum_bricks = SpectrumLayout(info).size()}),
      folder_(path.parent_path()) {}

std::unique_ptr<Scratch> FileSink::new_scratch() const {
  return std::make_unique<ScratchFile>(folder_);
}

// ---- memory

class MemorySink::Bricks : public BrickSource {
 public:
  explicit Bricks(std::size_t count) : bricks_(count) {}
  [[nodiscard]] RetainedBytes brick(std::size_t index) const override {
    return std::span<const std::byte>(bricks_[index]);
  }
  void set(std::size_t index, std::span<const std::byte> bytes) {
    bricks_[index].assign(bytes.begin(), bytes.end());
  }

 private:
  std::vector<std::vector<std::byte>> bricks_;
};

MemorySink::MemorySink(const DatasetInfo& info)
    : sample_bytes_(static_cast<std::size_t>(bytes_per_sample(info.type))),
      layout_(info.dims),
      samples_(std::make_shared<Bricks>(layout_.size())),
      spectrum_(std::make_shared<Bricks>(SpectrumLayout(info).size())) {}

void MemorySink::add_samples(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::size_t size = sample_bytes_ * layout_.volume(layout_.at(next_));
    samples_->set(next_++, bytes.first(size));
    bytes = bytes.subspan(size);
  }
}

void MemorySink::read_samples(std::size_t first, std::span<std::byte> bytes) const {
  while (!bytes.empty()) {
    const RetainedBytes brick = samples_->brick(first++);
    std::copy(brick.begin(), brick.end(), bytes.begin());
    bytes = bytes.subspan(brick.size());
  }
}

std::unique_ptr<Scratch> MemorySink::new_scratch() const {
  return std::make_unique<ScratchMemory>();
}

void MemorySink::add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes) {
  spectrum_->set(index, bytes);
}

std::shared_ptr<const BrickSource> MemorySink::samples() const { return samples_; }
std::shared_ptr<const BrickSource> MemorySink::spectrum() const { return spectrum_; }

}  // namespace multitetra
