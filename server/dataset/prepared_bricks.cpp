#include "server/dataset/prepared_bricks.hpp"

#include <cassert>
#include <utility>

namespace multitetra {

PreparedBricks::PreparedBricks(std::filesystem::path file, std::span<const std::byte> bytes,
                               const Section& section, std::size_t size,
                               std::optional<SampleType> type, const MappedFile* mapped)
    : file_(std::move(file)),
      section_(section.name),
      bytes_(bytes.subspan(section.offset, section.size)),
      size_(size),
      type_(type),
      mapped_(mapped),
      verified_(size) {}

KeptBytes PreparedBricks::brick(std::size_t index) const {
  assert(index < size_);
  if (mapped_ != nullptr) mapped_->check();
  reads_.fetch_add(1, std::memory_order_relaxed);
  const BrickPlace at = place(index);
  if (at.size == 0) return {};
  const std::span<const std::byte> bytes = bytes_.subspan(at.offset, at.size);
  if (verified_.contains(index)) return bytes;
  if (const auto whole = check_brick(section_, index, bytes, at.checksum, type_); !whole) {
    throw DatasetFileError(file_, whole.error().text);
  }
  verified_.add(index);
  return bytes;
}

SampleBricks::SampleBricks(std::filesystem::path file, std::span<const std::byte> bytes,
                           std::shared_ptr<const PreparedStructure> structure,
                           const MappedFile* mapped)
    : PreparedBricks(std::move(file), bytes, structure->section(section_names::kSamples),
                     structure->sample_checksums.size(), structure->metadata.info.type, mapped),
      structure_(std::move(structure)),
      layout_(structure_->metadata.info.dims) {}

BrickPlace SampleBricks::place(std::size_t index) const {
  return sample_brick_place(*structure_, layout_, index);
}

SpectrumBricks::SpectrumBricks(std::filesystem::path file, std::span<const std::byte> bytes,
                               std::shared_ptr<const PreparedStructure> structure,
                               const MappedFile* mapped)
    : PreparedBricks(std::move(file), bytes, structure->section(section_names::kSpectrum),
                     structure->spectrum_index.size(), std::nullopt, mapped),
      structure_(std::move(structure)) {}

BrickPlace SpectrumBricks::place(std::size_t index) const {
  return structure_->spectrum_index[index];
}

}  // namespace multitetra
