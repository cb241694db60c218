// Reads a small file that an option names: a certificate, a key, tokens.
#pragma once

#include <filesystem>
#include <string>

namespace multitetra {

// Never waits, whatever the file is. Throws ExitError (kNoSecrets), with `what` it is ("tokens
// file") and its name, when it is no regular file, cannot be read, or has more than 16 MiB.
[[nodiscard]] std::string read_secret_file(const std::string& what,
                                           const std::filesystem::path& file);

}  // namespace multitetra
