// The part of a mesh inside a box.
#pragma once

#include "common/base/affine.hpp"
#include "common/mesh/triangle_mesh.hpp"
#include "common/request/local_thresholds.hpp"

namespace multitetra {

// A box in coordinates of its own, such as sample indices.
struct PlacedBox {
  BoxShape box = {};
  Affine world_to_box = {};
};

// Returns the triangles inside the box, those across its faces cut at them. Each vertex is used;
// cuts of neighboring triangles have vertices of their own.
[[nodiscard]] TriangleMesh clipped(const TriangleMesh& mesh, const PlacedBox& box);

}  // namespace multitetra
