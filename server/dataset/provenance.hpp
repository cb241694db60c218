// The origin of a dataset, stored in it for the record.
#pragma once

#include <filesystem>
#include <string>

namespace multitetra {

struct Provenance {
  std::string file;          // The file's name without its directory, or the generator's options.
  std::string digest;        // XXH3-128 of the file's bytes as 32 hexadecimal digits; may be empty.
  std::string options = {};  // Options of reading and preparing that differ from the defaults.

  friend bool operator==(const Provenance&, const Provenance&) = default;
};

// Returns the name of a source's dataset: its name without folder and suffixes, such as "chris_t1"
// for "chris_t1.nii.gz"; for a pattern without its placeholders: "slice" for "slice_%03d.tif", and
// the folder's name for "*.tif".
[[nodiscard]] std::string default_dataset_name(const std::filesystem::path& source);

// Describes a source. The digest of a folder covers the names and bytes of all files below it; it
// is empty for patterns and addresses. Throws DatasetFileError if a file cannot be read.
[[nodiscard]] Provenance provenance(const std::filesystem::path& source);

}  // namespace multitetra
