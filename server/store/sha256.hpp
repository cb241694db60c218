// SHA-256 digests as 64 lowercase hexadecimal digits.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace multitetra {

[[nodiscard]] std::string sha256_hex(std::span<const std::byte> bytes);

// Returns the digest of a file's bytes; empty if it is no regular file or cannot be read.
[[nodiscard]] std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace multitetra
