// Surfaces as objects of the Python package.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "common/base/affine.hpp"
#include "common/mesh/content_digest.hpp"
#include "common/mesh/mesh.hpp"
#include "common/mesh/mesh_checks.hpp"

namespace multitetra {

// What is certain of a mesh.
struct SurfaceFacts {
  std::string length_unit;  // Of the vertices; empty: unknown.
  std::string space;        // Their axes: "LPS", "RAS" or "".
  MeshTopology topology;
  ContentDigest digest;
  // Bounds the distance to the full-resolution surface, rounding included; absent: no bound.
  std::optional<double> error_bound = {};
  bool is_full_resolution = false;
  bool preserves_topology = false;
  bool is_intersection_free = false;
};

// Positions whose memory is first written when they are set, by the thread that does.
class WorldVertices {
 public:
  WorldVertices() = default;
  explicit WorldVertices(std::size_t size)
      : positions_(std::make_unique_for_overwrite<Vec3[]>(size)), size_(size) {}

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] Vec3* data() { return positions_.get(); }

 private:
  std::unique_ptr<Vec3[]> positions_;
  std::size_t size_ = 0;
};

// Returns vertices in world coordinates, on all threads. In double precision no vertex moves.
[[nodiscard]] WorldVertices world_vertices(const LatticeMesh& mesh, const Affine& grid_to_world);

// Returns a multitetra.mesh.Mesh with the mesh's elements and these vertices, without a copy.
// Reverses faces if the map mirrors.
[[nodiscard]] pybind11::object mesh_of(LatticeMesh mesh, WorldVertices vertices,
                                       const Affine& grid_to_world, const SurfaceFacts& facts);

}  // namespace multitetra
