// The bytes of a prepared dataset (.mtd), without any I/O. README.md describes every byte.
//
//   +--------+-------+----------+----------+---------+----------+---------+
//   | header | table | checksum | metadata | padding |  ...     | samples |
//   +--------+-------+----------+----------+---------+----------+---------+
//    24 bytes 40 each  8 bytes   JSON       zeros      sections that
//                                                      later versions add
//
// All numbers are little-endian, checksums are XXH3-64, sections begin at multiples of 64. Every
// byte is covered: by the magic, the table's checksum, a section's checksum, or as zero padding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "common/result.hpp"
#include "server/dataset/dataset.hpp"
#include "server/dataset/dataset_file.hpp"

namespace multitetra {

inline constexpr std::uint32_t kDatasetFormatVersion = 1;

struct DatasetMetadata {
  DatasetInfo info;
  SourceNote source;
  std::string program_version;  // Of the program that wrote the file.

  friend bool operator==(const DatasetMetadata&, const DatasetMetadata&) = default;
};

// Bytes that can be read in any order: a file, or memory in tests.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  // Requires offset + into.size() <= size(). Throws what the source throws when it fails.
  virtual void read(std::uint64_t offset, std::span<std::byte> into) const = 0;
};

// What precedes the samples in a file; the file is this and then the samples. Requires metadata
// without `first_problem` and as many bytes of samples as its dims and type say.
[[nodiscard]] std::string encode_head(const DatasetMetadata& metadata,
                                      std::span<const std::byte> samples);

// The samples as the bytes of the section "samples".
[[nodiscard]] std::span<const std::byte> sample_bytes(const Samples& samples);

// Everything but the samples: header, table, padding and metadata are verified. kDamagedData, with
// the section and what is wrong, or kUnsupportedVersion. Allocates at most 1 MiB and a little.
[[nodiscard]] Result<DatasetMetadata> decode_metadata(const ByteSource& source);

struct DecodedDataset {
  DatasetMetadata metadata;
  Dataset dataset;
};

// Everything: sections that this version does not know are verified too. Allocates the size of the
// source and a little at most.
[[nodiscard]] Result<DecodedDataset> decode_dataset(const ByteSource& source);

}  // namespace multitetra
