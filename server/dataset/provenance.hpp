// The origin of a dataset, stored in it for the record.
#pragma once

#include <filesystem>
#include <string>

namespace multitetra {

struct Provenance {
  std::string file;          // The file's name without its directory, or the generator's options.
  std::string digest;        // XXH3-128 of the file's bytes as 32 hexadecimal digits; may be empty.
  std::string options = {};  // Options of reading and preparing other than the defaults.

  friend bool operator==(const Provenance&, const Provenance&) = default;
};

// The note for a source. The digest of a folder is that of the names and bytes of all files below
// it; it is empty for what is neither a file nor a folder (a pattern, an address). Throws
// DatasetFileError when the file cannot be read.
[[nodiscard]] Provenance provenance(const std::filesystem::path& source);

}  // namespace multitetra
