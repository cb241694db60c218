#include "server/dataset/dataset_writer.hpp"

#include <algorithm>
#include <cassert>
#include <string>
#include <system_error>
#include <utility>

#include "common/base/in_parallel.hpp"
#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/dataset/brick_order.hpp"
#include "server/dataset/detail/packed_bytes.hpp"
#include "server/dataset/detail/statistics.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kBatchBricks = 512;  // Packed at a time; bounds memory.

// Rethrows disk errors as DatasetFileError.
template <typename Action>
auto on_disk(const Action& action) {
  try {
    return action();
  } catch (const std::system_error& error) {
    throw DatasetFileError(std::string(error.what()) + ".");
  }
}

}  // namespace

DatasetWriter::DatasetWriter(const std::filesystem::path& path, const DatasetInfo& info)
    : path_(path),
      file_(on_disk([&] { return AtomicFile(path); })),
      layout_(info.dims),
      type_(info.type),
      samples_(on_disk([&] { return ScratchFile(path.parent_path()); })),
      spectrum_(on_disk([&] { return ScratchFile(path.parent_path()); })),
      spectrum_places_(SpectrumLayout(info).size()) {}

void DatasetWriter::add_samples(std::span<const std::byte> bytes) {
  on_disk([&] { return samples_.put(bytes); });
  sample_bytes_ += bytes.size();
}

void DatasetWriter::read_samples(std::size_t first, std::span<std::byte> into) const {
  const auto width = static_cast<std::size_t>(bytes_per_sample(type_));
  on_disk([&] { samples_.get(layout_.offset(layout_.at(first)) * width, into); });
}

void DatasetWriter::add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes) {
  assert(index < spectrum_places_.size() && spectrum_places_[index].size == 0);
  assert(bytes.size() <= max_spectrum_brick_bytes());
  if (bytes.empty()) return;
  spectrum_places_[index] = {.offset = on_disk([&] { return spectrum_.put(bytes); }),
                             .size = bytes.size()};
}

void DatasetWriter::finish(const DatasetMetadata& metadata, const SmallSections& small) {
  const auto width = static_cast<std::size_t>(bytes_per_sample(type_));
  [[maybe_unused]] const GridCounts last = layout_.at(layout_.size() - 1);
  assert(sample_bytes_ == width * (layout_.offset(last) + layout_.volume(last)));
  finish(metadata, small, [&](std::size_t index) {
    std::vector<std::byte> brick(layout_.volume(layout_.at(index)) * width);
    read_samples(index, brick);
    return pack_brick(brick, width);
  });
}

void DatasetWriter::finish(const DatasetMetadata& metadata, const SmallSections& small,
                           const PackedSamples& samples) {
  assert(check_info(metadata.info));
  assert(metadata.info.dims == layout_.dims() && metadata.info.type == type_);
  const SpectrumLayout spectrum(metadata.info);
  assert(spectrum_places_.size() == spectrum.size());
  assert(small.coarse.size == coarse_bytes(metadata.info));
  assert(small.ranges.size == ranges_bytes(metadata.info));
  end_ = kHeadBytes;
  const std::string text = metadata_text(metadata);
  write_section(section_names::kMetadata, std::as_bytes(std::span(text)));
  write_section(section_names::kBins, small.bins);
  const bool has_errors = metadata.info.missing.empty();
  const std::size_t index_section = sections_.size();
  if (has_errors) {
    // Reserves the space; write_spectrum() writes the index once the bricks are packed.
    const std::vector<BrickEntry> unknown(spectrum.size());
    write_section(section_names::kSpectrumIndex, std::as_bytes(std::span(unknown)));
  }
  write_packed_section(section_names::kCoarse, small.coarse);
  write_packed_section(section_names::kRanges, small.ranges);
  if (has_errors) write_spectrum(spectrum, index_section);
  const std::vector<BrickEntry> index = write_bricks(section_names::kSamples, layout_, samples);
  write_section(section_names::kSampleIndex, std::as_bytes(std::span(index)));
  const std::string head = encode_head(sections_);
  on_disk([&] {
    file_.write_at(0, std::as_bytes(std::span(head)));
    file_.commit(Durability::kMachineStop);
  });
}

void DatasetWriter::write_spectrum(const SpectrumLayout& layout, std::size_t index_section) {
  const std::vector<BrickEntry> index =
      write_bricks(section_names::kSpectrum, layout, [&](std::size_t brick) {
        std::vector<std::byte> bytes(spectrum_places_[brick].size);
        on_disk([&] { spectrum_.get(spectrum_places_[brick].offset, bytes); });
        return pack_sized(bytes);
      });
  const auto index_bytes = std::as_bytes(std::span(index));
  sections_[index_section].checksum = checksum(index_bytes);
  on_disk([&] { file_.write_at(sections_[index_section].offset, index_bytes); });
}

void DatasetWriter::write(std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  on_disk([&] { file_.write_at(end_, bytes); });
  sum_.add(bytes);
  end_ += bytes.size();
  sections_.back().size += bytes.size();
}

// Skips the padding before the section, which then reads as zeros.
void DatasetWriter::begin_section(const char* name) {
  end_ = section_begin(end_);
  sections_.push_back({.name = name, .offset = end_});
  sum_ = RunningChecksum();
}

void DatasetWriter::write_section(const char* name, std::span<const std::byte> bytes) {
  begin_section(name);
  write(bytes);
  end_section();
}

void DatasetWriter::write_packed_section(const char* name, const SectionBytes& bytes) {
  begin_section(name);
  pack_bytes(bytes.size, static_cast<std::size_t>(bytes_per_sample(type_)), bytes.read,
             [&](std::span<const std::byte> packed) { write(packed); });
  end_section();
}

template <typename Layout>
std::vector<BrickEntry> DatasetWriter::write_bricks(const char* name, const Layout& layout,
                                                    const PackedSamples& packed) {
  begin_section(name);
  std::vector<BrickEntry> index;
  index.reserve(layout.size());
  std::vector<std::size_t> batch;
  std::vector<PackedBrick> bricks;
  std::vector<std::byte> bytes;
  const auto write_batch = [&] {
    bricks.resize(batch.size());
    in_parallel(batch.size(), [&](std::size_t i) { bricks[i] = packed(batch[i]); });
    const std::uint64_t begin = sections_.back().size;
    bytes.clear();
    for (const PackedBrick& brick : bricks) {
      assert(brick.bytes.size() <= kMaxPackedBytes);
      bytes.resize(static_cast<std::size_t>(brick_begin(begin + bytes.size()) - begin));
      bytes.insert(bytes.end(), brick.bytes.begin(), brick.bytes.end());
      index.push_back({.size_and_codec = size_with_codec(brick.bytes.size(), brick.codec),
                       .checksum = brick_checksum(brick.bytes)});
    }
    write(bytes);
    batch.clear();
  };
  in_file_order(layout, [&](std::size_t brick) {
    batch.push_back(brick);
    if (batch.size() == kBatchBricks) write_batch();
  });
  write_batch();
  end_section();
  return index;
}

}  // namespace multitetra
