// Where a dataset came from, kept with it for people who wonder later.
#pragma once

#include <filesystem>
#include <string>

namespace multitetra {

struct SourceNote {
  std::string file;    // The file's name without its directory, or the generator's options.
  std::string digest;  // XXH3-128 of the file's bytes as 32 hexadecimal digits; may be empty.

  friend bool operator==(const SourceNote&, const SourceNote&) = default;
};

// The note for a source file. The digest is empty when `source` is no regular file (a directory or
// a pattern of images). Throws DatasetFileError when the file cannot be read.
[[nodiscard]] SourceNote source_note(const std::filesystem::path& source);

}  // namespace multitetra
