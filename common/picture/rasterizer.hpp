// Draws surfaces, in the colors of their vertices if they have some: perspective, hidden-surface
// removal, transparent surfaces, smooth or flat shading, antialiased edges, optional wireframes.
//
//   const Camera camera = framing(skin.positions, azimuth, elevation, 1280, 960);
//   write_file("head.png", png_file(drawn({{.mesh = &skin, .opacity = 0.4}, {.mesh = &bone}},
//                                         camera, {})));
//
// Every pixel has eight samples. Corners are rounded to 1/256 pixel, and each sample belongs to
// exactly one of the triangles that meet at an edge, so a watertight mesh is drawn without cracks.
// With translucent surfaces every sample blends all surfaces in its line of sight, nearest first,
// however they nest (an A-buffer; Carpenter 1984), with the parts of a volume between them. The
// same surfaces and camera give the same pixels with any number of threads.
//
// Existing renderers need a display or a driver, or their pictures differ between machines.
#pragma once

#include <optional>
#include <span>

#include "common/image/picture.hpp"
#include "common/mesh/mesh.hpp"
#include "common/picture/camera.hpp"
#include "common/picture/shading.hpp"
#include "common/picture/volume.hpp"

namespace multitetra {

enum class Shading {
  // Uses the mesh's normals, or if it has none averaged normals of its triangles.
  kSmooth,
  // Uses the normals of the triangles.
  kFlat,
};

struct DrawnSurface {
  const PositionedMesh* mesh = nullptr;  // Not null.
  double opacity = 1;                    // Above 0, up to 1 (opaque).
  // nullopt: the default color. Colors of vertices have precedence.
  std::optional<Light> color = std::nullopt;
};

struct DrawOptions {
  Background background = Background::kDark;
  Shading shading = Shading::kSmooth;
  // Draws the triangles' edges as lines one pixel wide. On triangles smaller than a few pixels the
  // lines fade, so that the shape of the surface stays visible.
  bool wireframe = false;
  const DrawnVolume* volume = nullptr;  // Null: none. In the surfaces' coordinates.
  int threads = 0;                      // 0: one per processor.
};

// Clips triangles at the picture's border and omits those that reach behind the eye. Cameras of
// framing() have all places in view.
[[nodiscard]] Picture drawn(std::span<const DrawnSurface> surfaces, const Camera& camera,
                            const DrawOptions& options);
// Draws one opaque surface.
[[nodiscard]] Picture drawn(const PositionedMesh& mesh, const Camera& camera,
                            const DrawOptions& options);

}  // namespace multitetra
