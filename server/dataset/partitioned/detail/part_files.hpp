// The output of a part for the merge: plain arrays of bytes, and a record of them that is written
// last. A part without a record is none.
//
//     head.mtd.parts/plan.json
//     head.mtd.parts/3.bricks    its packed bricks of samples, in the order of the dataset's file
//     head.mtd.parts/3.index     size, codec and checksum of each, as in the section "smplidx"
//     head.mtd.parts/3.ranges    of its cells, x fastest
//     head.mtd.parts/3.coarse    its coarse samples, x fastest
//     head.mtd.parts/3.curves    what the coarser levels of the spectrum are made from
//     head.mtd.parts/3.json      the record: the plan, sizes and checksums of these files
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "common/base/atomic_file.hpp"
#include "common/base/result.hpp"
#include "server/core/spectrum/spectrum_builder.hpp"
#include "server/dataset/byte_source.hpp"
#include "server/dataset/checksum.hpp"

namespace multitetra {

// ---- JSON that proves itself whole

// Adds the field "checksum", XXH3-64 of the JSON without it: compact, keys in the order of the
// alphabet.
[[nodiscard]] std::string text_with_checksum(nlohmann::json& json);
// kDamagedData unless it is such JSON, with that "format" and version 1.
[[nodiscard]] Result<nlohmann::json> json_with_checksum(std::string_view text, const char* format);

// A text of at most 256 MiB; nullopt when there is no such file. Throws DatasetFileError.
[[nodiscard]] std::optional<std::string> small_text(const std::filesystem::path& file);
// Whole or not at all, in a folder that is made where there is none. Throws DatasetFileError.
void write_whole(const std::filesystem::path& file, std::string_view text);

// ---- arrays

struct ArrayFacts {
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;

  friend bool operator==(const ArrayFacts&, const ArrayFacts&) = default;
};

// Bytes that are added one after the other. Throws DatasetFileError when the disk fails.
class ArrayWriter {
 public:
  explicit ArrayWriter(const std::filesystem::path& file);
  void add(std::span<const std::byte> bytes);
  ArrayFacts finish();  // Nothing after it.

 private:
  AtomicFile file_;
  RunningChecksum sum_;
  std::uint64_t bytes_ = 0;
};

// Curves that are put from several threads, and taken out again.
class CurvesWriter : public Scratch {
 public:
  explicit CurvesWriter(const std::filesystem::path& file);
  [[nodiscard]] std::uint64_t put(std::span<const std::byte> bytes) override;
  void get(std::uint64_t offset, std::span<std::byte> into) const override;
  ArrayFacts finish();  // Nothing after it.

 private:
  AtomicFile file_;
  std::mutex mutex_;  // Guards writing.
  std::uint64_t bytes_ = 0;
};

// Such a file, read again.
class CurvesReader : public Scratch {
 public:
  explicit CurvesReader(const std::filesystem::path& file) : source_(file) {}
  [[nodiscard]] std::uint64_t put(std::span<const std::byte> bytes) override;  // Not to be called.
  void get(std::uint64_t offset, std::span<std::byte> into) const override;

 private:
  FileSource source_;
};

// Throws DatasetFileError unless the file is as it was written.
void check_array(const std::filesystem::path& file, const ArrayFacts& facts);

// ---- records

struct PartRecord {
  std::uint64_t plan = 0;  // Its id.
  std::size_t part = 0;    // From 0 on.
  ArrayFacts bricks;
  ArrayFacts index;
  ArrayFacts ranges;
  ArrayFacts coarse;
  ArrayFacts curves;
  CellCurves cell_curves;

  friend bool operator==(const PartRecord& a, const PartRecord& b) = default;
};

[[nodiscard]] std::string record_text(const PartRecord& record);
[[nodiscard]] Result<PartRecord> parse_record(std::string_view text);

// "head.mtd.parts/3.json" of part 2.
[[nodiscard]] std::filesystem::path part_file(const std::filesystem::path& dataset,
                                              std::size_t part, const char* suffix);

}  // namespace multitetra
