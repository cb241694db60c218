// Estimates the size of a simplified surface from some simplified blocks of it.
//
// A block's border stays as it is, and so do most triangles at it: what is left is nearly linear in
// the edges of the border. In a tile, which is larger, it has a smaller part. How many triangles an
// edge of the border keeps is seen where the same blocks are left apart once, and joined once.
#pragma once

#include <cstddef>

namespace multitetra {

// Sums over blocks of the same side.
struct SimplifiedBlocks {
  std::size_t count = 0;  // With any triangle.
  double before = 0;      // Triangles.
  double left = 0;        // Triangles.
  // The border edges of one triangle, where tiles would continue.
  double border_edges = 0;
};

// Triangles for every edge of the border, 0 to 1, from the same surface in small blocks and in
// larger ones. Where these are no basis, from the remaining share: measured 0.6 where a third is
// left, 0.98 where a hundredth is.
[[nodiscard]] double triangles_a_border_edge(const SimplifiedBlocks& apart,
                                             const SimplifiedBlocks& joined);

// The share of `before` triangles of a surface that is left, 0 to 1, cut into tiles as
// simplified_cube.hpp does. 1 where nothing is known.
[[nodiscard]] double remaining_share(const SimplifiedBlocks& blocks, double a_border_edge,
                                     double before);

// The same, roughly, where no block was simplified; the error in voxels. Rather too small than too
// large. Public volumes have 0.3 at a tenth of a voxel, 0.04 to 0.2 at half a voxel, 0.007 and more
// at two.
[[nodiscard]] double rough_remaining_share(double voxels);

// The remaining share of a preview, where no block is simplified to measure it: 0.04 to 0.25 on
// public volumes.
inline constexpr double kLeftOfPreview = 0.15;

// Simplified triangles are irregular: each takes so many times the bytes of another:
// 1.2 to 1.5 on public volumes.
inline constexpr double kBytesOfSimplifiedTriangles = 1.35;

}  // namespace multitetra
