// XML VTK image data (.vti), as ParaView and VTK write it: one piece; samples as text, base64 or
// appended (raw or base64), plain or packed with zlib or LZ4.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>

#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {

// The point array called choice.array; without a name the one that the file calls its scalars, or
// else its first. A file without point arrays gives a cell array, whose samples lie at the middles
// of the cells. Throws VolumeFileError.
[[nodiscard]] StoredVolume open_vti(const std::filesystem::path& file, const VolumeChoice& choice);

// One piece of a .pvti, which may be a part of its whole extent.
struct VtiPiece {
  StoredVolume volume;
  // The extent of the piece.
  std::array<std::int64_t, 6> extent{};
  bool of_cells = false;
  // The piece is a part of the whole extent in the file.
  bool is_part = false;
};
[[nodiscard]] VtiPiece open_vti_piece(const std::filesystem::path& file,
                                      const VolumeChoice& choice);

}  // namespace multitetra
