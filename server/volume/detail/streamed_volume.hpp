// A VolumeSource over slices in files, which are read on demand and then converted.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "server/volume/detail/sample_conversion.hpp"
#include "server/volume/formats/stored_volume.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

// The volume of `stored`, converted according to SampleConversion. `file` is its name in notices.
// Passes the notices of the file's reader to `notice` at once, and those of conversions and
// infinite samples when the last slice has been read for the first time. Requires dims within the
// largest grid. Throws VolumeFileError when a component must be chosen.
[[nodiscard]] std::unique_ptr<VolumeSource> streamed_volume(std::filesystem::path file,
                                                            StoredVolume stored,
                                                            ComponentChoice component,
                                                            Notice notice);

}  // namespace multitetra
