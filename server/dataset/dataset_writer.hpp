// Writes a prepared dataset piece by piece, in memory that does not grow with the volume.
//
//   DatasetWriter writer("head.mtd", {.dims = {512, 512, 234}, .type = SampleType::kI16,
//                                     .spectrum_bricks = SpectrumLayout(info).size()});
//   for (...) writer.add_samples(layer_of_bricks);
//   for (...) writer.add_spectrum_brick(index, bytes);   // Also between the samples.
//   writer.finish(metadata, {.coarse = ..., .ranges = ..., .bins = ...});
//
// Samples and spectrum wait as they are in files without names beside the dataset, so that the disk
// must hold them, too; finish() packs them on all threads and writes the file in its order.
//
// Guaranteed: the file appears whole or not at all (AtomicFile), also when the writer is killed or
// the machine stops. Without finish() nothing appears. The same bytes for the same content, for any
// number of threads and in whatever order and pieces it came.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "common/base/atomic_file.hpp"
#include "common/base/scratch_file.hpp"
#include "server/dataset/checksum.hpp"
#include "server/dataset/prepared_format.hpp"

namespace multitetra {

// Properties that the writer needs before the first brick.
struct DatasetShape {
  GridCounts dims{};
  SampleType type = SampleType::kU8;
  std::size_t spectrum_bricks = 0;  // SpectrumLayout(info).size(), empty ones included.
};

// A section that need not be in memory as a whole.
struct SectionBytes {
  using Read = std::function<void(std::uint64_t offset, std::span<std::byte> into)>;

  SectionBytes() = default;
  SectionBytes(std::span<const std::byte> bytes)  // NOLINT: as good as its bytes.
      : size(bytes.size()), read([bytes](std::uint64_t offset, std::span<std::byte> into) {
          std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), into.size(),
                      into.begin());
        }) {}
  SectionBytes(std::uint64_t bytes, const Scratch& scratch)
      : size(bytes), read([&scratch](std::uint64_t offset, std::span<std::byte> into) {
          scratch.get(offset, into);
        }) {}

  std::uint64_t size = 0;
  Read read;
};

// Sections for first previews, beside the bricks. Each may be empty.
struct SmallSections {
  SectionBytes coarse;
  SectionBytes ranges;
  std::span<const std::byte> bins;
};

// Gives brick `index` of the samples, packed as pack_brick() does. Called from several threads.
using PackedSamples = std::function<PackedBrick(std::size_t index)>;

// All functions throw DatasetFileError when the disk fails. To be used by one thread at a time,
// but for read_samples.
class DatasetWriter {
 public:
  DatasetWriter(const std::filesystem::path& path, const DatasetShape& shape);

  // The next bricks in the order of BrickLayout(dims), as many as these bytes hold: normally a
  // layer. Requires that they end where a brick ends, and that no sample is infinite.
  void add_samples(std::span<const std::byte> bytes);

  // The bytes of brick `first` and of those after it. Requires that they were added. From several
  // threads at once, also while spectrum bricks are added.
  void read_samples(std::size_t first, std::span<std::byte> into) const;

  // In any order. Requires index < spectrum_bricks, each at most once, and at most
  // most_spectrum_brick_bytes(). A brick that is never added is empty.
  void add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes);

  // Brings the file to the disk and gives it its name. Requires that all samples were added, that
  // the metadata passes `check_info` and agrees with the shape, and nothing after it.
  void finish(const DatasetMetadata& metadata, const SmallSections& small);
  // The same with samples from elsewhere; requires that none were added.
  void finish(const DatasetMetadata& metadata, const SmallSections& small,
              const PackedSamples& samples);

 private:
  struct SpectrumPlace {
    std::uint64_t offset = 0;  // In the scratch.
    std::uint64_t size = 0;
  };
  void write(std::span<const std::byte> bytes);
  void begin_section(const char* name);
  void end_section() { sections_.back().checksum = sum_.value(); }
  void write_section(const char* name, std::span<const std::byte> bytes);
  void write_packed_section(const char* name, const SectionBytes& bytes);
  // Returns the index.
  template <typename Layout>
  std::vector<BrickEntry> write_bricks(const char* name, const Layout& layout,
                                       const PackedSamples& packed);

  std::filesystem::path path_;
  AtomicFile file_;
  DatasetShape shape_;
  BrickLayout layout_;

  ScratchFile samples_;
  std::uint64_t sample_bytes_ = 0;  // Added so far.
  ScratchFile spectrum_;
  std::vector<SpectrumPlace> spectrum_places_;

  // Filled by finish().
  SectionTable sections_;
  std::uint64_t end_ = 0;  // The end of what was written.
  // The checksum of the current section.
  RunningChecksum sum_;
};

}  // namespace multitetra
