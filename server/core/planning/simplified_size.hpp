// Estimates the size of a simplified surface from some simplified blocks of it.
//
// The border of a block is not simplified, nor are most triangles along it: the number of remaining
// triangles is nearly linear in the border's edges. In a tile, which is larger, the border has a
// smaller share. The number of triangles per border edge follows from comparing the same blocks,
// separate and joined.
#pragma once

#include <cstddef>

namespace multitetra {

// Sums over blocks of the same side.
struct SimplifiedBlocks {
  std::size_t count = 0;  // Nonempty blocks.
  double before = 0;      // Triangles before simplification.
  double left = 0;        // Triangles after simplification.
  // Edges of one triangle only, where tiles would continue.
  double border_edges = 0;
};

// Returns the triangles per border edge, 0 to 1, from the same surface in small and in larger
// blocks. If these do not suffice, from the remaining share: measured 0.6 if a third is left, 0.98
// if a hundredth is.
[[nodiscard]] double estimate_triangles_per_border_edge(const SimplifiedBlocks& apart,
                                                        const SimplifiedBlocks& joined);

// Returns the share of a surface's `before` triangles that remains, 0 to 1, when it is cut into
// tiles as in simplified_cube.hpp; 1 without data.
[[nodiscard]] double remaining_share(const SimplifiedBlocks& blocks,
                                     double triangles_per_border_edge, double before);

// Returns a rough, rather small remaining share without any blocks, for an error in voxels. Public
// volumes have 0.3 at a tenth of a voxel, 0.04 to 0.2 at half a voxel, 0.007 and more at two.
[[nodiscard]] double rough_remaining_share(double voxels);

// The remaining share assumed for previews, without any blocks: 0.04 to 0.25 on public volumes.
inline constexpr double kPreviewRemainingShare = 0.15;

// The ratio of bytes per triangle of simplified to other meshes, as simplified triangles are
// irregular: 1.2 to 1.5 on public volumes.
inline constexpr double kBytesOfSimplifiedTriangles = 1.35;

}  // namespace multitetra
