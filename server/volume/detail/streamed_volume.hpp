// A VolumeSource that reads slices from files on demand and converts them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "server/volume/detail/sample_conversion.hpp"
#include "server/volume/formats/stored_volume.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

// Returns the volume of `stored`, converted by SampleConversion. `file` names it in notices. The
// reader's notices are passed on at once; those of conversions and infinite samples follow once
// every slice has been read. Reading the last slice throws VolumeFileError if conversion loses more
// than `loss`. Requires dims within the largest grid. Throws VolumeFileError if a
// component must be chosen.
[[nodiscard]] std::unique_ptr<VolumeSource> streamed_volume(std::filesystem::path file,
                                                            StoredVolume stored,
                                                            ComponentChoice component,
                                                            AllowedLoss loss, Notice notice);

}  // namespace multitetra
