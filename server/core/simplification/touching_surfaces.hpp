// Divides surfaces that touch, such as those of a segmentation's labels, into patches that are
// simplified one by one, and joins the patches again.
//
//   std::vector<SurfacePatch> patches = patches_of(surfaces);
//   simplify_patches(patches, options);
//   const std::vector<LatticeMesh> results = joined_patches(patches, surfaces.size());
//
// A patch belongs to one surface or to two: triangles that two surfaces have with opposite
// orientations are their common border. A common border is simplified once, so afterwards the two
// surfaces still have the same triangles there, and neither overlap nor part.
//
// Simplification never moves the border vertices of a mesh (see collapsing_mesh.hpp). The patches
// of a surface therefore fit together afterwards, the topology of the surface is preserved, and its
// two-sided Hausdorff distance to the original is at most the largest bound of its patches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "server/core/simplification/simplification.hpp"

namespace multitetra {

struct SurfacePatch {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  // The number of its surface. Triangles face as they do there.
  std::uint32_t first = 0;
  std::uint32_t second = kNone;  // The surface on the other side, greater than `first`, or kNone.
  LatticeMesh mesh = {};
  // The bound in Simplified.
  double bound = 0;
};

// Returns the patches of all surfaces, sorted by `first`, then `second`. Requires surfaces of one
// lattice resolution, without normals and scalars.
[[nodiscard]] std::vector<SurfacePatch> patches_of(std::span<const LatticeMesh> surfaces);

// Simplifies one patch. With `options.is_intersection_free` it then intersects none of the other
// patches that it did not intersect before.
void simplify_patch(
    std::vector<SurfacePatch>& patches, std::size_t index, const SimplificationOptions& options,
    const std::function<void()>& checkpoint = [] {});

// Returns the surfaces, each assembled from its patches, with the largest bound of these. Surfaces
// without triangles have the lattice resolution of the patches.
[[nodiscard]] std::vector<Simplified> joined_patches(std::span<const SurfacePatch> patches,
                                                     std::size_t surface_count);

}  // namespace multitetra
