// Writes a prepared dataset piece by piece, in memory that does not grow with the volume.
//
//   DatasetWriter writer("head.mtd", info);
//   for (...) writer.add_samples(layer_of_bricks);
//   for (...) writer.add_spectrum_brick(index, bytes);   // Also between the samples.
//   writer.finish(metadata, {.coarse = ..., .ranges = ..., .bins = ...});
//
// Samples and spectrum are buffered uncompressed in unnamed temporary files beside the dataset, so
// the disk must hold them as well; finish() compresses them on all threads and writes the file.
//
// Guaranteed: the file appears complete or not at all (AtomicFile), even if the process is killed
// or the machine stops; without finish() nothing appears. Equal content gives equal bytes, for any
// number of threads and any order and size of the pieces.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "common/base/atomic_file.hpp"
#include "common/base/scratch_file.hpp"
#include "common/mesh/checksum.hpp"
#include "server/dataset/prepared_format.hpp"

namespace multitetra {

// The destination to which preparation writes the samples of a volume.
class BrickSink {
 public:
  virtual ~BrickSink() = default;
  // Appends whole bricks in the order of BrickLayout(dims), normally a layer. Requires finite
  // samples or NaN.
  virtual void add_samples(std::span<const std::byte> bytes) = 0;
  [[nodiscard]] virtual std::unique_ptr<Scratch> new_scratch() const = 0;
};

// A section that is read in pieces, so it need not fit into memory.
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

// Sections for first previews. Each may be empty.
struct SmallSections {
  SectionBytes coarse;
  SectionBytes ranges;
  std::span<const std::byte> bins;
};

// Returns brick `index` of the samples, packed as by pack_brick(). Called from several threads.
using PackedSamples = std::function<PackedBrick(std::size_t index)>;

// All functions throw DatasetFileError if the disk fails. Not thread-safe, except for
// read_samples().
class DatasetWriter final : public BrickSink {
 public:
  // Requires the dimensions, the type and the geometry of `info` only.
  DatasetWriter(const std::filesystem::path& path, const DatasetInfo& info);

  void add_samples(std::span<const std::byte> bytes) override;

  // Returns scratch space on the disk of the file.
  [[nodiscard]] std::unique_ptr<Scratch> new_scratch() const override {
    return std::make_unique<ScratchFile>(path_.parent_path());
  }

  // Reads brick `first` and those after it, which must have been added. May be called from several
  // threads, also while spectrum bricks are added.
  void read_samples(std::size_t first, std::span<std::byte> into) const;

  // Adds a brick, in any order. Requires index < SpectrumLayout(info).size(), each index at most
  // once, and at most max_spectrum_brick_bytes(). Bricks that are never added are empty.
  void add_spectrum_brick(std::size_t index, std::span<const std::byte> bytes);

  // Writes the file to disk under its name. Must be the last call. Requires that all samples were
  // added and that the metadata passes `check_info` and matches `info`. Leaves out the spectrum
  // if the metadata says that errors are missing.
  void finish(const DatasetMetadata& metadata, const SmallSections& small);
  // Finishes the file with samples from elsewhere; requires that none were added.
  void finish(const DatasetMetadata& metadata, const SmallSections& small,
              const PackedSamples& samples);

 private:
  struct SpectrumPlace {
    std::uint64_t offset = 0;  // In the scratch file.
    std::uint64_t size = 0;
  };
  void write(std::span<const std::byte> bytes);
  void begin_section(const char* name);
  void end_section() { sections_.back().checksum = sum_.value(); }
  void write_section(const char* name, std::span<const std::byte> bytes);
  void write_packed_section(const char* name, const SectionBytes& bytes);
  // Returns the index of the bricks.
  void write_spectrum(const SpectrumLayout& layout, std::size_t index_section);
  template <typename Layout>
  std::vector<BrickEntry> write_bricks(const char* name, const Layout& layout,
                                       const PackedSamples& packed);

  std::filesystem::path path_;
  AtomicFile file_;
  BrickLayout layout_;
  SampleType type_;

  ScratchFile samples_;
  std::uint64_t sample_bytes_ = 0;  // Added so far.
  ScratchFile spectrum_;
  std::vector<SpectrumPlace> spectrum_places_;

  // Set by finish().
  SectionTable sections_;
  std::uint64_t end_ = 0;  // End of the bytes written so far.
  // Checksum of the current section.
  RunningChecksum sum_;
};

}  // namespace multitetra
