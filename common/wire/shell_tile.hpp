// A tile in a sample shell, decoded: the samples are marched. Does not see Draco.
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

// Parameters that all shells of a step share.
struct ShellTileForm {
  int lattice_resolution = kDefaultLatticeResolution;
  std::int32_t finest_spacing = 1;
  ShellStep shell = {};
};

// Whether the payload has the digest, and its header the counts, the form and a place in the cube,
// that were promised. kDamagedData, naming the tile and the first difference, otherwise.
[[nodiscard]] Result<void> check_shell_tile(std::string_view payload, const TileSummary& promised,
                                            const ShellTileForm& form);

// The box of cells that decode_shell_tile() marches, in lattice coordinates: what it then returns
// is as TileInCube::marched says. None where samples are void, so that tetrahedra are left out, or
// where the payload has no header.
[[nodiscard]] std::optional<MarchedBox> marched_box(std::string_view payload);

// Checks and decodes. Takes memory in proportion to `promised`, and time in proportion to the
// cube's cells. Every vertex lies in the cube, is used, and is there once; every edge within the
// cube has one or two triangles, which agree on the outside.
[[nodiscard]] Result<LatticeMesh> decode_shell_tile(std::string_view payload,
                                                    const TileSummary& promised,
                                                    const ShellTileForm& form);

}  // namespace multitetra
