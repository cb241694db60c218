// The prepared dataset on disk: one .mtd file. README.md in this folder describes it byte by byte.
//
//   write_dataset("head.mtd", dataset, source_note("CThead.nhdr"));
//   DatasetPtr head = open_dataset("head.mtd");
//
// Guaranteed: a file appears whole or not at all, also when the machine stops in the middle. What
// is opened is bit for bit what was written; every byte of the file is verified first, and any
// damage is a DatasetFileError. A damaged file never makes the reader allocate more than in
// proportion to the file's size.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "server/dataset/dataset.hpp"

namespace multitetra {

// A prepared file that cannot be written or read, or that is damaged. The text names the file, the
// section and what is wrong.
class DatasetFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Where a dataset came from, kept with it for people who wonder later.
struct SourceNote {
  std::string file;    // The file's name without its directory, or the generator's options.
  std::string digest;  // XXH3-128 of the file's bytes as 32 hexadecimal digits; may be empty.

  friend bool operator==(const SourceNote&, const SourceNote&) = default;
};

// The note for a source file. The digest is empty when `source` is no regular file (a directory or
// a pattern of images). Throws DatasetFileError when the file cannot be read.
[[nodiscard]] SourceNote source_note(const std::filesystem::path& source);

// Requires `first_problem(dataset.info)` to be none and the info to agree with the volume. Throws
// DatasetFileError.
void write_dataset(const std::filesystem::path& path, const Dataset& dataset,
                   const SourceNote& source);

// Throws DatasetFileError.
[[nodiscard]] DatasetPtr open_dataset(const std::filesystem::path& path);

// The note that was given to write_dataset. Verifies everything but the samples. Throws
// DatasetFileError.
[[nodiscard]] SourceNote read_source_note(const std::filesystem::path& path);

}  // namespace multitetra
