#include "server/stream/surface_provider.hpp"

#include "server/core/planning/surface_size.hpp"

namespace multitetra {

SurfaceSize size_of(const EncodedStep& step) {
  SurfaceSize size;
  for (const EncodedTile& tile : step.tiles) {
    size.triangles += tile.summary.triangles;
    size.bytes += tile.summary.bytes;
  }
  size.extracted = step.is_in_shells
                       ? size.triangles
                       : kTrianglesPerTetrahedron * static_cast<double>(step.active_tetrahedra);
  return size;
}

}  // namespace multitetra
