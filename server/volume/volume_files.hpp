// Opens volumes of every supported format (listed in formats/volume_formats.hpp), and raw bytes
// with a given layout. A sandboxed process with bounded memory reads each file
// (detail/sandboxed_reader.hpp): no file can crash or hang the caller.
//
//   Volume head = read_volume("CThead.nhdr");
//   Volume fuel = read_volume("fuel.raw", {.raw = RawLayout{.dims = {64, 64, 64}}});
//   const auto larger_than_memory = open_volume("body.nhdr");  // See volume_source.hpp.
//
// Guaranteed: 8-bit and 16-bit integers and 32-bit floats keep their type and bits, unless the file
// has a slope or an intercept, which are applied. 32-bit and 64-bit integers and 64-bit floats
// become f32, and infinite samples become void (NaN); `notice` reports both. NaN samples are void.
//
// Coordinates: medical formats use the LPS system (x to the patient's left, y to the back, z to the
// head; RAS headers are converted); other files keep their numbers. `meaning` names the system.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "server/core/framework/volume.hpp"
#include "server/volume/formats/described_raw.hpp"
#include "server/volume/placement.hpp"
#include "server/volume/volume_source.hpp"

namespace multitetra {

// What the notice of infinite samples, which become void, contains.
inline constexpr const char* kInfiniteNotice = "beyond the range of f32";

struct VolumeFileOptions {
  // If present, the file is read as raw bytes.
  std::optional<RawLayout> raw = std::nullopt;
  // Selects one of several volumes or components.
  VolumeChoice choice = {};
  // Overrides the placement in the file.
  Placement placement = {};
  // Called with a sentence for each conversion; for open_volume(), while the source is read.
  std::function<void(const std::string&)> notice = nullptr;
};

// Reads one volume. `path` is a file or folder, a file and a path inside it ("a.h5:/volume"), or a
// pattern of TIFF, PNG or JPEG images: printf style ("slice%03d.tif") or with '*' and '?'
// ("slice*.tif"). The images of a stack are slices along z in natural order (slice2 before
// slice10). Throws VolumeFileError.
[[nodiscard]] Volume read_volume(const std::filesystem::path& path,
                                 const VolumeFileOptions& options = {});

// Opens the same volume as a stream of slabs, so that memory does not limit its size. Samples that
// are text, or compressed as a whole, are read forward. Throws VolumeFileError if the header is
// damaged or, where the file's size reveals it, samples are missing.
[[nodiscard]] std::unique_ptr<VolumeSource> open_volume(const std::filesystem::path& path,
                                                        const VolumeFileOptions& options = {});

// Returns trusted slices of this process, such as those of an array, as a source, with the
// conversions of files. Of the options it takes `notice`, and `subtract` and `allow_loss` of the
// choice. `name` names the slices in texts. Throws VolumeFileError if a size is out of range or
// axes are not at right angles.
[[nodiscard]] std::unique_ptr<VolumeSource> volume_of_slices(const std::string& name,
                                                             StoredVolume slices,
                                                             const VolumeFileOptions& options = {});

}  // namespace multitetra
