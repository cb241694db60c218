// A VolumeSource over slices that lie in files: read when they are asked for, then converted.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "server/volume/detail/sample_conversion.hpp"
#include "server/volume/formats/stored_volume.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

// The volume that `stored` makes up, converted as SampleConversion says. `file` is its name in
// notices. Tells `notice` what the file's reader has to say at once, and of conversions and
// infinite samples when the last slice has been read for the first time. Requires dims within the
// largest grid. Throws VolumeFileError when a component must be chosen.
[[nodiscard]] std::unique_ptr<VolumeSource> streamed_volume(std::filesystem::path file,
                                                            StoredVolume stored,
                                                            ComponentChoice component,
                                                            Notice notice);

}  // namespace multitetra
