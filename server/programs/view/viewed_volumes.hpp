// Classifies the inputs of `view`: which ones are datasets, which volumes belong together, and how
// to prepare them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/programs/prepare/prepare_arguments.hpp"

namespace multitetra {

// Returns the volume to show by default, a file installed with the programs. Throws ExitError if it
// is missing.
[[nodiscard]] std::filesystem::path demo_volume();

// The initial view, as address parameters: bone behind translucent skin. Also in demo.sh.
inline constexpr std::string_view kDemoLook =
    "&isovalue=-300.5&color=e0ac8d&opacity=0.45&min_component=20&surfaces=300.5,f3ead6,,,,,20"
    "&axes=false";

// Returns whether the input is a dataset, or a folder of datasets without volumes; neither needs
// preparation.
[[nodiscard]] bool is_prepared(const std::string& input);

// Returns whether `serve` must prepare the input: a volume file, an address other than that of
// datasets, or a folder of volumes without any dataset.
[[nodiscard]] bool is_unprepared(const std::string& input);

// Returns the preparations of the inputs, each for a separate folder; `output` is left empty.
// Numbered files on the same grid become one time series of all their fields; a file with several
// times, fields or named labels becomes a series unless `volume` chooses one. Reads headers only.
// Throws VolumeFileError, ExitError.
[[nodiscard]] std::vector<PrepareArguments> preparations_of(std::vector<std::string> inputs,
                                                            const VolumeOptions& volume);

// Returns the preparation of every label of a label map as a separate surface.
[[nodiscard]] PrepareArguments preparation_of_labels(const std::string& input);

// Returns the label maps of a volume: the label images in the folder of an OME-Zarr, or a file
// recognized by its name: "ct_seg.nii.gz", "ct-labels.nrrd" or "ct.seg.nrrd" next to "ct.nii.gz",
// or "labels.nii.gz" if the folder has only one other volume.
[[nodiscard]] std::vector<std::string> label_maps_of(const std::filesystem::path& volume);

// Returns the name of a cache entry, from the content of the inputs and the options. Reads all
// input bytes. For addresses, and for files that may be headers of other files, it also depends on
// the place.
[[nodiscard]] std::string cache_key(const PrepareArguments& arguments);

}  // namespace multitetra
