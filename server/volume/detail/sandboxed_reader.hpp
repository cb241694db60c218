// A volume source in a process of its own: what its reader does wrong with a damaged file stays
// there, and memory and time are bounded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "server/volume/detail/sample_conversion.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

// Called with the bytes of samples that a source holds in memory as a whole; 0: it reads slab by
// slab.
using HeaderIsKnown = std::function<void(std::uint64_t held_bytes)>;

// Opens a source. Notices go to the given function; `header_is_known` is called before memory for
// samples is allocated.
using OpenSource = std::function<std::unique_ptr<VolumeSource>(
    const Notice& notice, const HeaderIsKnown& header_is_known)>;

// The source that `open` makes in another process. `path` is its name in sentences. Until the
// header is known that process may have 1 GiB beyond what this one has, afterwards 6 GiB and what
// the source holds as a whole, at most the machine's memory. Throws VolumeFileError as `open` does,
// and when the process crashes or is silent for longer than any reader should be.
[[nodiscard]] std::unique_ptr<VolumeSource> sandboxed_volume(const std::filesystem::path& path,
                                                             const OpenSource& open, Notice notice);

}  // namespace multitetra
