// The inputs of `view`: which of them are datasets already, which
// volumes belong together, and how they are prepared.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/programs/prepare/prepare_arguments.hpp"

namespace multitetra {

// The volume that is shown when none is named: a file beside the programs. Throws ExitError when it
// is not there.
[[nodiscard]] std::filesystem::path demo_volume();

// The first view, as a part of an address: bone behind translucent skin.
// demo.sh has the same words.
inline constexpr std::string_view kDemoLook =
    "&isovalue=-300.5&color=e0ac8d&opacity=0.45&min_component=20&surfaces=300.5,f3ead6,,,,,20"
    "&axes=false";

// Whether the input is a dataset, or a folder of datasets that has no volumes; neither needs any
// preparation.
[[nodiscard]] bool is_prepared(const std::string& input);

// How the inputs are prepared, each result into a folder of its own; `output` is not set yet. Files
// numbered alike on the same grid are one time series, of all their fields; a file with several
// times, fields or named labels becomes a series of them unless `volume` chooses one. Opens
// volumes, but reads headers only. Throws VolumeFileError, ExitError.
[[nodiscard]] std::vector<PrepareArguments> preparations_of(const std::vector<std::string>& inputs,
                                                            const VolumeOptions& volume);

// Every label of a label map as a surface of its own.
[[nodiscard]] PrepareArguments preparation_of_labels(const std::string& input);

// The label maps that belong to a volume: the label images in the folder of an OME-Zarr, or a file
// beside the volume that is known by its name: "ct_seg.nii.gz", "ct-labels.nrrd" or "ct.seg.nrrd"
// beside "ct.nii.gz", or "labels.nii.gz" where only one other volume is in the folder.
[[nodiscard]] std::vector<std::string> label_maps_of(const std::filesystem::path& volume);

// The name of a cache entry for what a preparation reads and the options it reads it with. Reads
// all bytes of its inputs. An address, and a file small enough to be a header of samples elsewhere,
// counts by its place as well.
[[nodiscard]] std::string cache_key(const PrepareArguments& arguments);

}  // namespace multitetra
