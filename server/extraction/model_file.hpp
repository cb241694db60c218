// A model's tetrahedra as a file for volume rendering in ParaView: VTK XML UnstructuredGrid (.vtu).
#pragma once

#include <string>

#include "common/base/affine.hpp"
#include "server/extraction/model_cells.hpp"

namespace multitetra {

// Returns the bytes of the file: points mapped by `grid_to_output`, with the point array "value"
// (float32) and the cell array "size" (grid steps). Appended raw, little endian, 64-bit counts.
[[nodiscard]] std::string vtu_file(const ModelCells& model, const Affine& grid_to_output);

}  // namespace multitetra
