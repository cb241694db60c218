#include "server/dataset/dataset_writer.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <string>
#include <system_error>
#include <utility>

#include "server/core/spectrum/spectrum_layout.hpp"
#include "server/dataset/statistics.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;
constexpr std::size_t kPageBytes = 4096;  // Of file systems: smaller holes save nothing.

std::uint64_t sample_bytes_in(const DatasetShape& shape) {
  std::uint64_t bytes = static_cast<std::uint64_t>(bytes_per_sample(shape.type));
  for (const std::int32_t side : shape.dims) bytes *= static_cast<std::uint64_t>(side);
  return bytes;
}

// The disk's trouble, in the words of datasets.
template <typename Action>
auto on_disk(const Action& action) {
  try {
    return action();
  } catch (const std::system_error& error) {
    throw DatasetFileError(std::string(error.what()) + ".");
  }
}

}  // namespace

DatasetWriter::DatasetWriter(const std::filesystem::path& path, const DatasetShape& shape)
    : file_(on_disk([&] { return AtomicFile(path); })),
      shape_(shape),
      layout_(shape.dims),
      spectrum_begin_(section_begin(kHeadBytes + sample_bytes_in(shape))),
      spectrum_index_(shape.spectrum_bricks) {
  constexpr std::byte kZero{};
  write(spectrum_begin_ - 1, {&kZero, 1});  // What is never written before it reads as zero.
}

void DatasetWriter::add_samples(std::span<const std::byte> bytes) {
  const auto width = static_cast<std::size_t>(bytes_per_sample(shape_.type));
  write_but_zeros(kHeadBytes + sample_bytes_, bytes);
  samples_checksum_.add(bytes);
  sample_bytes_ += bytes.size();
  while (!bytes.empty()) {
    assert(sample_checksums_.size() < layout_.size());
    const std::size_t brick = sample_checksums_.size();
    const std::size_t size = layout_.volume(layout_.at(brick)) * width;
    assert(size <= bytes.size());
    sample_checksums_.push_back(checksum(bytes.first(size)));
    assert(check_brick(section_names::kSamples, brick, bytes.first(size), sample_checksums_.back(),
                       shape_.type));
    bytes = bytes.subspan(size);
  }
}

void DatasetWriter::read_samples(std::size_t first, std::span<std::byte> into) const {
  const auto width = static_cast<std::size_t>(bytes_per_sample(shape_.type));
  on_disk([&] { file_.read_at(kHeadBytes + layout_.offset(layout_.at(first)) * width, into); });
}

void DatasetWriter::add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes) {
  assert(index < spectrum_index_.size() && spectrum_index_[index].size == 0);
  assert(bytes.size() <= std::numeric_limits<std::uint32_t>::max());
  if (bytes.empty()) return;
  spectrum_index_[index] = {.offset = spectrum_bytes_,
                            .size = static_cast<std::uint32_t>(bytes.size()),
                            .checksum = checksum(bytes)};
  spectrum_bytes_ += bytes.size();
  spectrum_buffer_.insert(spectrum_buffer_.end(), bytes.begin(), bytes.end());
  if (spectrum_buffer_.size() >= kBufferBytes) flush_spectrum();
}

void DatasetWriter::finish(const DatasetMetadata& metadata, const SmallSections& small) {
  assert(check_info(metadata.info));
  assert(metadata.info.dims == shape_.dims && metadata.info.type == shape_.type);
  assert(shape_.spectrum_bricks == SpectrumLayout(metadata.info).size());
  assert(sample_bytes_ == sample_bytes_in(shape_));
  flush_spectrum();
  sections_ = {{.name = section_names::kSamples,
                .offset = kHeadBytes,
                .size = sample_bytes_,
                .checksum = samples_checksum_.value()},
               {.name = section_names::kSpectrum,
                .offset = spectrum_begin_,
                .size = spectrum_bytes_,
                .checksum = spectrum_checksum_.value()}};
  append_section(section_names::kCoarse, small.coarse);
  append_section(section_names::kRanges, small.ranges);
  append_section(section_names::kBins, small.bins);
  append_section(section_names::kSampleChecksums, std::as_bytes(std::span(sample_checksums_)));
  append_section(section_names::kSpectrumIndex, std::as_bytes(std::span(spectrum_index_)));
  const std::string text = metadata_text(metadata);
  append_section(section_names::kMetadata, std::as_bytes(std::span(text)));
  const std::string head = encode_head(sections_);
  write(0, std::as_bytes(std::span(head)));
  on_disk([&] { file_.commit(Durability::kMachineStop); });
}

void DatasetWriter::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  on_disk([&] { file_.write_at(offset, bytes); });
}

void DatasetWriter::write_but_zeros(std::uint64_t offset, std::span<const std::byte> bytes) {
  std::size_t begin = 0;  // Of what is to be written.
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t page =
        std::min<std::size_t>(bytes.size() - at, kPageBytes - (offset + at) % kPageBytes);
    const auto in_page = bytes.subspan(at, page);
    if (std::all_of(in_page.begin(), in_page.end(), [](std::byte b) { return b == std::byte{}; })) {
      if (begin < at) write(offset + begin, bytes.subspan(begin, at - begin));
      begin = at + page;
    }
    at += page;
  }
  if (begin < bytes.size()) write(offset + begin, bytes.subspan(begin));
}

void DatasetWriter::flush_spectrum() {
  write(spectrum_begin_ + spectrum_bytes_ - spectrum_buffer_.size(), spectrum_buffer_);
  spectrum_checksum_.add(spectrum_buffer_);
  spectrum_buffer_.clear();
}

// The zeros before it are never written, and read as zero.
void DatasetWriter::append_section(const char* name, const SectionBytes& bytes) {
  const Section& last = sections_.back();
  const std::uint64_t begin = section_begin(last.offset + last.size);
  RunningChecksum sum;
  std::vector<std::byte> buffer;
  for (std::uint64_t done = 0; done < bytes.size; done += buffer.size()) {
    buffer.resize(
        static_cast<std::size_t>(std::min<std::uint64_t>(kBufferBytes, bytes.size - done)));
    bytes.read(done, buffer);
    write(begin + done, buffer);
    sum.add(buffer);
  }
  sections_.push_back({.name = name, .offset = begin, .size = bytes.size, .checksum = sum.value()});
}

}  // namespace multitetra
