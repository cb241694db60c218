// Draws surfaces, in the colors of their vertices if they have some: perspective, hidden-surface
// removal, transparent surfaces, smooth or flat shading, antialiased edges, optional wireframes.
//
//   const Camera camera = framing(skin.positions, azimuth, elevation, 1280, 960);
//   write_file("head.png", png_file(drawn({{.mesh = &skin, .opacity = 0.4}, {.mesh = &bone}},
//                                         camera, {})));
//
// Every pixel is sampled in eight places. A sample belongs to exactly one of the triangles that
// meet at an edge, as their corners are rounded to 1/256 pixel first: a mesh without cracks is
// drawn without any. Where surfaces are seen through, every sample is mixed of all that lie in its
// line of sight, the nearest first, however they nest (an A-buffer; Carpenter 1984). The same
// surfaces and camera give the same pixels with any number of threads.
//
// There are renderers enough, but none of them draws the same picture everywhere without a display
// or a driver, and this is all that a picture of one surface needs.
#pragma once

#include <optional>
#include <span>

#include "client/picture/camera.hpp"
#include "client/picture/shading.hpp"
#include "common/image/picture.hpp"
#include "common/mesh/mesh.hpp"

namespace multitetra {

enum class Shading {
  // By the mesh's normals or, if it has none, those of its triangles, averaged at corners.
  kSmooth,
  kFlat,  // By each triangle's own normal.
};

struct DrawnSurface {
  const PositionedMesh* mesh = nullptr;       // Not null.
  double opacity = 1;                         // More than 0, at most 1: nothing is seen through it.
  std::optional<Light> color = std::nullopt;  // None: the usual one. Those of vertices come first.
};

struct DrawOptions {
  Background background = Background::kDark;
  Shading shading = Shading::kSmooth;
  // Draws the triangles' edges as lines, one pixel wide. Where triangles are smaller than a few
  // pixels the lines fade, so that the surface's shape remains to be seen.
  bool wireframe = false;
  int threads = 0;  // 0: one for each processor.
};

// Triangles may lie beside the picture; those that reach behind the eye are left out. framing()
// sees to it that all are in front of it and in the picture.
[[nodiscard]] Picture drawn(std::span<const DrawnSurface> surfaces, const Camera& camera,
                            const DrawOptions& options);
// One surface that nothing is seen through.
[[nodiscard]] Picture drawn(const PositionedMesh& mesh, const Camera& camera,
                            const DrawOptions& options);

}  // namespace multitetra
