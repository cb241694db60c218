// A prepared dataset, opened for reading: one .mtd file on this machine or behind an address.
// FORMAT.md describes it byte by byte; DatasetWriter writes it.
//
//   const PreparedFile head("head.mtd");
//   const PreparedFile far("https://store.example/head.mtd", files);
//   const RetainedBytes first = head.samples()->brick(0);
//
// Guaranteed: what is handed out is bit for bit what was written. Opening verifies the structure
// and the small sections (of a far file those that it fetches); it takes milliseconds, or one
// request. Bricks are verified when they are looked at, see prepared_bricks.hpp; verify_dataset.hpp
// verifies all at once. Any damage is a DatasetFileError, and a damaged file never makes the reader
// allocate more than in proportion to the file's size.
//
// A file on this machine is mapped into memory. It must stay as it is while it is open: replace it
// by renaming, as our writer does, and never write into it. One that was changed nevertheless is
// noticed, as damage: by brick(), and by check(). A far file that was replaced is a StoreError.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "common/request/dataset_info.hpp"
#include "server/dataset/dataset_metadata.hpp"
#include "server/dataset/prepared_bricks.hpp"
#include "server/store/remote_files.hpp"

namespace multitetra {

// A value that is cheap to copy; copies share the file. What the functions return stays as long as
// one of the copies, or one of the sources, lives. Safe to use from several threads.
class PreparedFile {
 public:
  // Without `files` a small cache is made for this file alone. Throws DatasetFileError, StoreError.
  explicit PreparedFile(const std::string& place, std::shared_ptr<RemoteFiles> files = nullptr);

  [[nodiscard]] const DatasetMetadata& metadata() const;
  [[nodiscard]] const DatasetInfo& info() const { return metadata().info; }
  [[nodiscard]] const SectionTable& sections() const;
  [[nodiscard]] std::uint64_t bytes() const;  // The size of the file.

  // DatasetInfo::content_id, from checksums: no sample is read.
  [[nodiscard]] std::uint64_t content_id() const;

  // Throws DatasetFileError when the file was changed since it was opened: what was looked at since
  // then may be anything.
  void check() const;

  // As many bricks as BrickLayout(info().dims) and SpectrumLayout(info()) have.
  [[nodiscard]] std::shared_ptr<const PreparedBricks> samples() const;
  [[nodiscard]] std::shared_ptr<const PreparedBricks> spectrum() const;

  // As they were given to DatasetWriter::finish. The first two are read and unpacked on first use,
  // and throw what reading a brick throws.
  [[nodiscard]] std::span<const std::byte> coarse() const;
  [[nodiscard]] std::span<const std::byte> ranges() const;
  [[nodiscard]] std::span<const std::byte> bins() const;

 private:
  struct Content;
  std::shared_ptr<const Content> content_;
};

}  // namespace multitetra
