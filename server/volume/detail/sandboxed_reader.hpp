// Runs a volume source in a process of its own, which contains the faults of a reader on a damaged
// file and bounds its memory and time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "server/volume/detail/sample_conversion.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

// Called with the bytes of samples that a source holds in memory; 0 if it reads slab by slab.
using HeaderIsKnown = std::function<void(std::uint64_t held_bytes)>;

// Opens a source. Must call `header_is_known` before it allocates memory for samples.
using OpenSource = std::function<std::unique_ptr<VolumeSource>(
    const Notice& notice, const HeaderIsKnown& header_is_known)>;

// Returns the source that `open` creates in another process. `path` names it in messages. Until the
// header is known, that process may use 1 GiB more memory than this one; afterwards 6 GiB plus the
// bytes the source holds, at most the machine's memory. Throws VolumeFileError as `open` does, and
// if the process crashes or exceeds its time limit.
[[nodiscard]] std::unique_ptr<VolumeSource> sandboxed_volume(const std::filesystem::path& path,
                                                             const OpenSource& open, Notice notice);

}  // namespace multitetra
