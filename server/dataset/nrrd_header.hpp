// Three habits of NRRD writers that ITK's reader refuses, put right.
//
// The NRRD format asks that `space` or `space dimension` comes before the fields that depend on it,
// and ITK refuses per-axis `spacings` beside a `space`. Files that break this are common, and what
// they mean is clear: such a header is rewritten and ITK reads the rewritten one. A `space` that
// comes late moves up, one that is missing is a `space dimension` of 3, and one that only
// `spacings` use goes: it says nothing without directions.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace multitetra {

// The text of a detached header that means the same as `header`, the beginning of the NRRD file
// `file` up to its first empty line, and that ITK reads; nullopt when `header` needs no change.
// Names of data files become absolute, so the new header may lie anywhere.
[[nodiscard]] std::optional<std::string> rewritten_nrrd_header(std::string_view header,
                                                               const std::filesystem::path& file);

// The lines of `file` up to its first empty line; at most 1 MiB of them.
[[nodiscard]] std::string read_nrrd_header(const std::filesystem::path& file);

}  // namespace multitetra
