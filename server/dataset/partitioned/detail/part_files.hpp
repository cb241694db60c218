// The files that a part leaves for the merge: plain byte arrays, and a record that is written last.
// A part without a record does not count as prepared.
//
//     head.mtd.parts/plan.json
//     head.mtd.parts/3.bricks    its packed bricks of samples, in the order of the dataset's file
//     head.mtd.parts/3.index     size, codec and checksum of each, as in the section "smplidx"
//     head.mtd.parts/3.ranges    the ranges of its cells, x fastest
//     head.mtd.parts/3.coarse    its coarse samples, x fastest
//     head.mtd.parts/3.curves    the input for the coarser levels of the spectrum
//     head.mtd.parts/3.json      the record: the plan, sizes and checksums of these files
#pragma once

#include <array>
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
#include "common/mesh/checksum.hpp"
#include "server/core/spectrum/spectrum_builder.hpp"
#include "server/dataset/byte_source.hpp"

namespace multitetra {

// ---- JSON with a checksum

// Adds the field "checksum": XXH3-64 of the compact JSON without it, keys in alphabetical order.
[[nodiscard]] std::string text_with_checksum(nlohmann::json& json);
// Parses such JSON. Returns kDamagedData unless checksum, "format" and version (1) match.
[[nodiscard]] Result<nlohmann::json> json_with_checksum(std::string_view text, const char* format);

// Reads a text of at most 256 MiB; nullopt if the file does not exist. Throws DatasetFileError.
[[nodiscard]] std::optional<std::string> small_text(const std::filesystem::path& file);
// Writes the file atomically and creates its folder if needed. Throws DatasetFileError.
void write_whole(const std::filesystem::path& file, std::string_view text);

// ---- arrays

struct ArrayFacts {
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;

  friend bool operator==(const ArrayFacts&, const ArrayFacts&) = default;
};

// Writes an array piece by piece. Throws DatasetFileError if the disk fails.
class ArrayWriter {
 public:
  explicit ArrayWriter(const std::filesystem::path& file);
  void add(std::span<const std::byte> bytes);
  ArrayFacts finish();  // Must be the last call.

 private:
  AtomicFile file_;
  RunningChecksum sum_;
  std::uint64_t bytes_ = 0;
};

// Stores curves from several threads; they can be read back at once.
class CurvesWriter : public Scratch {
 public:
  explicit CurvesWriter(const std::filesystem::path& file);
  [[nodiscard]] std::uint64_t put(std::span<const std::byte> bytes) override;
  void get(std::uint64_t offset, std::span<std::byte> into) const override;
  ArrayFacts finish();  // Must be the last call.

 private:
  AtomicFile file_;
  std::mutex mutex_;  // Guards writing.
  std::uint64_t bytes_ = 0;
};

// Reads a finished file of curves.
class CurvesReader : public Scratch {
 public:
  explicit CurvesReader(const std::filesystem::path& file) : source_(file) {}
  [[nodiscard]] std::uint64_t put(std::span<const std::byte> bytes) override;  // Never called.
  void get(std::uint64_t offset, std::span<std::byte> into) const override;

 private:
  FileSource source_;
};

// Throws DatasetFileError unless the file has this size and checksum.
void check_array(const std::filesystem::path& file, const ArrayFacts& facts);

// ---- records

struct PartRecord {
  std::uint64_t plan = 0;  // The plan's id.
  std::size_t part = 0;    // Counted from 0.
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

// In the order in which they are written.
inline constexpr std::array<std::string_view, 6> kPartSuffixes = {".bricks", ".index",  ".ranges",
                                                                  ".coarse", ".curves", ".json"};

// Returns "head.mtd.parts/3.json" for part 2.
[[nodiscard]] std::filesystem::path part_file(const std::filesystem::path& dataset,
                                              std::size_t part, std::string_view suffix);
// Returns whether the name is that of a part's file, of this plan or an earlier one.
[[nodiscard]] bool is_part_file(const std::filesystem::path& file);

[[noreturn]] void fail_without_plan(const std::filesystem::path& dataset);

// Removes the plan and the files of parts, and their folder if nothing else is in it. Leaves what
// cannot be removed.
void remove_parts(const std::filesystem::path& dataset);

}  // namespace multitetra
