// Runs a volume source in a sandbox, which contains the faults of a reader on a damaged or hostile
// file and bounds its memory and time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "common/sandbox/sandbox.hpp"
#include "server/volume/detail/sample_conversion.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

// Called with the bytes of samples that a source holds in memory; 0 if it reads slab by slab.
using HeaderIsKnown = std::function<void(std::uint64_t held_bytes)>;

// Opens the source of a request. Must call `header_is_known` before it allocates memory for
// samples.
using OpenSource = std::function<std::unique_ptr<VolumeSource>(
    const std::string& request, const Notice& notice, const HeaderIsKnown& header_is_known)>;

// Returns a task for sandboxed_volume().
[[nodiscard]] SandboxTask reading(const std::string& name, OpenSource open);

// Returns the source that a reading() task opens in a sandbox. `path` names it in messages. Until
// the header is known, the reader may use 1 GiB of memory; afterwards 6 GiB plus the bytes the
// source holds, at most the machine's memory. Nothing that the reader sends is trusted. Throws
// VolumeFileError as the task does, and if the reader crashes, exceeds a limit, or sends what no
// source has; SandboxError if it cannot be started.
[[nodiscard]] std::unique_ptr<VolumeSource> sandboxed_volume(const std::filesystem::path& path,
                                                             const SandboxTask& task,
                                                             SandboxRules rules,
                                                             const std::string& request,
                                                             Notice notice);

}  // namespace multitetra
