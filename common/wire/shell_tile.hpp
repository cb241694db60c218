// Decodes a tile from a sample shell by marching its samples. Does not include Draco.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "common/base/result.hpp"
#include "common/mesh/merged_tiles.hpp"
#include "common/mesh/mesh.hpp"
#include "common/request/shell_step.hpp"
#include "common/wire/tile.hpp"

namespace multitetra {

// The parameters that all shells of a step share.
struct ShellTileForm {
  int lattice_resolution = kDefaultLatticeResolution;
  std::int32_t finest_spacing = 1;
  ShellStep shell = {};
};

// Checks the payload's digest, and its header's counts, form and position in the cube. Fails with
// kDamagedData, naming the tile and the first difference from `promised` and `form`.
[[nodiscard]] Result<void> check_shell_tile(std::string_view payload, const TileSummary& promised,
                                            const ShellTileForm& form);

// Returns the box of cells that decode_shell_tile() marches, in lattice coordinates; its result
// then has the guarantees of TileInCube::marched. Absent if samples are void, so that tetrahedra
// are skipped, or if the header is invalid.
[[nodiscard]] std::optional<MarchedBox> marched_box(std::string_view payload);

// Checks and decodes. Takes memory in proportion to `promised`, and time in proportion to the
// cube's cells. Every vertex lies in the cube, is used and occurs once; every edge inside the cube
// has one or two triangles, which are consistently oriented.
[[nodiscard]] Result<LatticeMesh> decode_shell_tile(std::string_view payload,
                                                    const TileSummary& promised,
                                                    const ShellTileForm& form);

}  // namespace multitetra
