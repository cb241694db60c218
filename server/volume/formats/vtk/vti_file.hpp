// XML VTK image data (.vti) as written by ParaView and VTK: one piece; samples as text, base64 or
// appended (raw or base64), uncompressed or compressed by zlib or LZ4.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// Opens the point array choice.array, or without a name the active scalars, or else the first
// array. Without point arrays, opens a cell array, with samples at cell centers. Throws
// VolumeFileError.
[[nodiscard]] StoredVolume open_vti(const std::filesystem::path& file, const VolumeChoice& choice);

// A piece of a .pvti file, which may be a part of its whole extent.
struct VtiPiece {
  StoredVolume volume;
  // Extent of the piece.
  std::array<std::int64_t, 6> extent{};
  bool of_cells = false;
  // The piece is a part of the whole extent in the file.
  bool is_part = false;
};
[[nodiscard]] VtiPiece open_vti_piece(const std::filesystem::path& file,
                                      const VolumeChoice& choice);

}  // namespace multitetra
