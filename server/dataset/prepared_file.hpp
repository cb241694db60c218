// A prepared dataset, opened for reading: one .mtd file, local or remote. FORMAT.md describes it
// byte by byte; DatasetWriter writes it.
//
//   const PreparedFile head("head.mtd");
//   const PreparedFile far("https://store.example/head.mtd", files);
//   const RetainedBytes first = head.samples()->brick(0);
//
// Guaranteed: all returned data are bit for bit what was written. Opening verifies the structure
// and the small sections (for a remote file, those that it fetches); it takes milliseconds, or one
// request. Bricks are verified on access, see prepared_bricks.hpp; verify_dataset.hpp verifies
// everything. Any damage is reported as DatasetFileError, and reading a damaged file never
// allocates more than in proportion to the file's size.
//
// A local file is mapped into memory. It must not change while it is open: replace it by renaming,
// as our writer does, and never write into it. If it changes anyway, brick() and check() report
// damage. A remote file that was replaced is reported as StoreError.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "common/dataset/dataset_info.hpp"
#include "server/dataset/dataset_metadata.hpp"
#include "server/dataset/prepared_bricks.hpp"
#include "server/store/remote_files.hpp"

namespace multitetra {

// Cheap to copy; copies share the file. Returned pointers and spans stay valid while one of the
// copies or one of the brick sources lives. Safe to use from several threads.
class PreparedFile {
 public:
  // Without `files` the file gets a small cache of its own. Throws DatasetFileError, StoreError.
  explicit PreparedFile(const std::string& place, std::shared_ptr<RemoteFiles> files = nullptr);
  // Reads the file from elsewhere; `place` names it in messages.
  PreparedFile(const std::string& place, std::shared_ptr<const ByteSource> source);

  [[nodiscard]] const DatasetMetadata& metadata() const;
  [[nodiscard]] const DatasetInfo& info() const { return metadata().info; }
  [[nodiscard]] const SectionTable& sections() const;
  [[nodiscard]] std::uint64_t bytes() const;  // Size of the file.

  // Returns DatasetInfo::content_id, computed from checksums without reading samples.
  [[nodiscard]] std::uint64_t content_id() const;

  // Throws DatasetFileError if the file has changed since it was opened; later reads are invalid.
  void check() const;

  // Return as many bricks as BrickLayout(info().dims) and SpectrumLayout(info()) have; no spectrum
  // if the file lacks it.
  [[nodiscard]] std::shared_ptr<const PreparedBricks> samples() const;
  [[nodiscard]] std::shared_ptr<const PreparedBricks> spectrum() const;

  // Return what was passed to DatasetWriter::finish. The first two are read and unpacked on first
  // use, and throw as reading a brick does.
  [[nodiscard]] std::span<const std::byte> coarse() const;
  [[nodiscard]] std::span<const std::byte> ranges() const;
  [[nodiscard]] std::span<const std::byte> bins() const;

 private:
  struct Content;
  std::shared_ptr<const Content> content_;
};

}  // namespace multitetra
