// How much a data file really holds: what is compared with what its header promises.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

namespace multitetra {

// Throws VolumeFileError, saying that `file` ends too early, unless found >= needed. `what` is what
// is counted.
void require_whole(const std::filesystem::path& file, std::uint64_t found, std::uint64_t needed,
                   std::string_view what = "bytes of samples");

// The bytes that the zlib or gzip stream at `offset` of the file inflates to; nullopt when the
// stream is damaged or ends too early. A file that is no such stream counts as it is.
[[nodiscard]] std::optional<std::uint64_t> inflated_bytes(const std::filesystem::path& file,
                                                          std::uint64_t offset);

// The words between white space from `offset` on, at most `enough` of them: the numbers of a text
// file. Stops at the first word that does not start like a number.
[[nodiscard]] std::uint64_t numbers_in_text(const std::filesystem::path& file, std::uint64_t offset,
                                            std::uint64_t enough);

// The bytes of the file from `offset` on; 0 when there is no such file.
[[nodiscard]] std::uint64_t bytes_after(const std::filesystem::path& file, std::uint64_t offset);

// Whether the chain of a TIFF file's directories, one for each page, ends inside the file. (libtiff
// takes a file that ends between two pages for one with fewer pages.)
[[nodiscard]] bool tiff_directories_are_whole(const std::filesystem::path& file);

}  // namespace multitetra
