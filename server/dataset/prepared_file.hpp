// A prepared dataset on disk, opened for reading: one .mtd file. README.md in this folder describes
// it byte by byte; DatasetWriter writes it.
//
//   const PreparedFile head("head.mtd");
//   const std::shared_ptr<const PreparedBricks> samples = head.samples();
//   std::span<const std::byte> first = samples->brick(0);
//
// Guaranteed: what is handed out is bit for bit what was written. Opening verifies everything but
// the two large sections, which are mapped into memory: it takes milliseconds, and memory is only
// needed for what is looked at. Those sections are verified brick by brick at the first look, see
// prepared_bricks.hpp; verify_dataset.hpp verifies all of it at once. Any damage is a
// DatasetFileError, and a damaged file never makes the reader allocate more than in proportion to
// the file's size.
//
// The file must stay as it is while it is open: replace it by renaming, as our writer does, and
// never write into it. One that was changed nevertheless is noticed, as damage: by brick(), and by
// check().
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

#include "common/request/dataset_info.hpp"
#include "server/dataset/dataset_metadata.hpp"
#include "server/dataset/prepared_bricks.hpp"

namespace multitetra {

// A value that is cheap to copy; copies share the file. What the functions return stays as long as
// one of the copies, or one of the sources, lives. Safe to use from several threads.
class PreparedFile {
 public:
  // Throws DatasetFileError.
  explicit PreparedFile(const std::filesystem::path& path);

  [[nodiscard]] const DatasetMetadata& metadata() const;
  [[nodiscard]] const DatasetInfo& info() const { return metadata().info; }

  // DatasetInfo::content_id, from checksums: no sample is read.
  [[nodiscard]] std::uint64_t content_id() const;

  // Throws DatasetFileError when the file was changed since it was opened: what was looked at since
  // then may be anything.
  void check() const;

  // As many bricks as BrickLayout(info().dims) and SpectrumLayout(info()) have.
  [[nodiscard]] std::shared_ptr<const PreparedBricks> samples() const;
  [[nodiscard]] std::shared_ptr<const PreparedBricks> spectrum() const;

  // As they were given to DatasetWriter::finish; each begins at a multiple of 64 bytes.
  [[nodiscard]] std::span<const std::byte> coarse() const;
  [[nodiscard]] std::span<const std::byte> ranges() const;
  [[nodiscard]] std::span<const std::byte> bins() const;

 private:
  struct Content;
  std::shared_ptr<const Content> content_;
};

}  // namespace multitetra
