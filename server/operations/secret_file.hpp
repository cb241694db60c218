// Reads a small file named by an option: a certificate, a key, tokens.
#pragma once

#include <filesystem>
#include <string>

namespace multitetra {

// Never blocks, whatever the file is. Throws ExitError (kBadCredentials), with `what` the file is
// ("tokens file") and its name, if it is not a regular file, cannot be read, or exceeds 16 MiB.
[[nodiscard]] std::string read_secret_file(const std::string& what,
                                           const std::filesystem::path& file);

}  // namespace multitetra
