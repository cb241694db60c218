#include "server/dataset/detail/prepared_sinks.hpp"

#include <algorithm>
#include <cassert>

#include "common/base/scratch_file.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"

namespace multitetra {

FileSink::FileSink(const std::filesystem::path& path, const DatasetInfo& info)
    : writer_(
          path,
          {.dims = info.dims, .type = info.type, .spectrum_bricks = SpectrumLayout(info).size()}),
      folder_(path.parent_path()) {}

std::unique_ptr<Scratch> FileSink::new_scratch() const {
  return std::make_unique<ScratchFile>(folder_);
}

MemorySink::MemorySink(const DatasetInfo& info)
    : layout_(info.dims), sample_bytes_(static_cast<std::size_t>(bytes_per_sample(info.type))) {
  samples_.reserve(offset_of(layout_.size() - 1) +
                   sample_bytes_ * layout_.volume(layout_.at(layout_.size() - 1)));
}

std::size_t MemorySink::offset_of(std::size_t brick) const {
  return sample_bytes_ * static_cast<std::size_t>(layout_.offset(layout_.at(brick)));
}

void MemorySink::add_samples(std::span<const std::byte> bytes) {
  samples_.insert(samples_.end(), bytes.begin(), bytes.end());
}

void MemorySink::read_samples(std::size_t first, std::span<std::byte> bytes) const {
  std::copy_n(samples_.begin() + static_cast<std::ptrdiff_t>(offset_of(first)), bytes.size(),
              bytes.begin());
}

std::unique_ptr<Scratch> MemorySink::new_scratch() const {
  return std::make_unique<ScratchMemory>();
}

void MemorySink::add_spectrum_brick(std::size_t, std::span<const std::byte>) {
  assert(false && "a dataset in memory has no errors");
}

RetainedBytes MemorySink::brick(std::size_t index) const {
  return std::span(samples_).subspan(offset_of(index),
                                     sample_bytes_ * layout_.volume(layout_.at(index)));
}

}  // namespace multitetra
