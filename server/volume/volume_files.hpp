// Opens volumes of every supported format (listed in formats/recognition.hpp), and raw bytes whose
// layout the caller knows. Every file is read by a sandboxed process with bounded memory
// (detail/sandboxed_reader.hpp): no file can crash or hang the caller.
//
//   Volume head = read_volume("CThead.nhdr");
//   Volume fuel = read_volume("fuel.raw", {.raw = RawLayout{.dims = {64, 64, 64}}});
//   const auto larger_than_memory = open_volume("body.nhdr");  // See volume_source.hpp.
//
// Guaranteed: 8-bit and 16-bit integers and 32-bit floats keep their type and their bits, unless
// the file has a slope or an intercept, which are applied. 32-bit and 64-bit integers and 64-bit
// floats become f32, infinite samples become void (NaN); both are reported through `notice`. NaN
// samples stay and mean void.
//
// Coordinates: medical formats are in the LPS system (x to the patient's left, y to the back, z to
// the head; headers in RAS are turned); files without a system of their own keep their numbers.
// `meaning` contains the system.
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

struct VolumeFileOptions {
  std::optional<RawLayout> raw = std::nullopt;  // Given: the file is read as raw bytes.
  VolumeChoice choice = {};  // Where the source holds several volumes, or numbers a sample.
  Placement placement = {};  // Replaces the placement in the file.
  // Receives a sentence for each conversion, from open_volume while the source is read.
  std::function<void(const std::string&)> notice = nullptr;
};

// Reads one volume. `path` is a file or folder, a file and a path inside it ("a.h5:/volume"), or a
// pattern of TIFF, PNG or JPEG images: either printf style ("slice%03d.tif") or with '*' and '?'
// ("slice*.tif"). Images of a stack are slices along z in natural order (slice2 before
// slice10). Throws VolumeFileError.
[[nodiscard]] Volume read_volume(const std::filesystem::path& path,
                                 const VolumeFileOptions& options = {});

// The same volume slab by slab: it streams, so that memory does not bound its size. Samples that
// are text or packed as a whole are read forwards. Throws VolumeFileError when the header is
// damaged or, where that can be known without reading them, the samples are not all there.
[[nodiscard]] std::unique_ptr<VolumeSource> open_volume(const std::filesystem::path& path,
                                                        const VolumeFileOptions& options = {});

}  // namespace multitetra
