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
  std::array<std::int64_t, 6> extent{};  // Of the piece.
  bool of_cells = false;
  bool is_part = false;  // Of the whole extent that the file tells.
};
[[nodiscard]] VtiPiece open_vti_piece(const std::filesystem::path& file,
                                      const VolumeChoice& choice);

}  // namespace multitetra
